// The pictures of a run: sizes, and what is drawn in which colour.
#include <gtest/gtest.h>

#include "tests/unit/decoded_png.h"
#include "tests/unit/sample_report.h"
#include "tools/report/report.h"

namespace parloc::tools {
namespace {

std::size_t pixels_of(const Picture& picture, int red, int green, int blue) {
  std::size_t n = 0;
  for (std::size_t k = 0; k + 2 < picture.rgb.size(); k += 3) {
    n += picture.rgb[k] == red && picture.rgb[k + 1] == green && picture.rgb[k + 2] == blue ? 1 : 0;
  }
  return n;
}

TEST_F(ReportTest, LivePictureHasMapPathRobotAndWords) {
  RunReport report = sample(&map_, 600);
  report.steps.clear(), report.errors.reset(), report.truth.reset(), report.odometry.clear();
  const auto drawn = [&](const std::string& caption) {
    write_live_picture(in_folder("live.png"), report, caption);
    return decode(test::content_of(in_folder("live.png")));
  };
  const Picture picture = drawn("12 scans");
  EXPECT_GE(std::max(picture.width, picture.height), 400);
  EXPECT_LE(std::max(picture.width, picture.height), 1050);
  EXPECT_GT(pixels_of(picture, 0, 114, 178), 300U);  // the path
  EXPECT_GT(pixels_of(picture, 213, 94, 0), 50U);    // the robot
  EXPECT_GT(pixels_of(picture, 25, 28, 32), pixels_of(drawn(""), 25, 28, 32) + 50U);
}

TEST_F(ReportTest, PictureIsAPngWithEveryPath) {
  const RunReport report = sample(&map_, 600);
  write_picture(in_folder("picture.png"), report);
  const std::string png = test::content_of(in_folder("picture.png"));
  ASSERT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1A\n");
  const Picture picture = decode(png);
  ASSERT_GE(picture.width, 1000);
  EXPECT_LE(std::max(picture.width, picture.height), 2100);
  EXPECT_GT(pixels_of(picture, 0, 114, 178), 1000U) << "estimate";
  EXPECT_GT(pixels_of(picture, 230, 159, 0), 1000U) << "truth";
  EXPECT_GT(pixels_of(picture, 181, 80, 140), 500U) << "odometry";
  EXPECT_GT(pixels_of(picture, 25, 28, 32), 1000U) << "walls";
}

TEST_F(ReportTest, ErrorPictureHasThreePanelsWithErrorAndBand) {
  for (const int steps : {300, 15000}) {  // a line, and so many samples that means are drawn
    write_error_picture(in_folder("errors.png"), sample(&map_, steps));
    const Picture picture = decode(test::content_of(in_folder("errors.png")));
    ASSERT_GT(picture.height, 600);
    const std::size_t panel = picture.rgb.size() / static_cast<std::size_t>(picture.height) * 220;
    for (std::size_t k = 0; k < 3; ++k) {
      std::size_t error = 0, band = 0;
      for (std::size_t p = k * panel; p < (k + 1) * panel; p += 3) {
        const int red = picture.rgb[p], green = picture.rgb[p + 1], blue = picture.rgb[p + 2];
        error += red == 0 && green == 114 && blue == 178 ? 1 : 0;
        band += green > red + 20 && green > blue ? 1 : 0;
      }
      EXPECT_GT(error, 500U) << k;
      EXPECT_GT(band, 1000U) << k;
    }
  }
}

}  // namespace
}  // namespace parloc::tools
