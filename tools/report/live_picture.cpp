#include "tools/report/live_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/error.h"
#include "common/file/output_file.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {
namespace {

constexpr const char* kPage = R"html(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"/>
<meta name="viewport" content="width=device-width, initial-scale=1"/>
<title>parloc: {0}</title>
<style>
:root{{color-scheme:light dark}}
body{{margin:0;font:16px/1.45 system-ui,sans-serif;text-align:center}}
h1{{font-size:1.1rem;font-weight:600;margin:.6rem 1rem;overflow-wrap:anywhere}}
img{{width:100vw;height:calc(100vh - 4.5rem);object-fit:contain}}
</style>
<noscript><meta http-equiv="refresh" content="1"/></noscript></head>
<body><h1>{0}</h1>
<p id="ended" hidden>The work has ended: <a href="{2}">{2}</a></p>
<img id="live" src="{1}" alt="The map so far"/>
<script>
const shown=document.getElementById('live'),ended=document.getElementById('ended');
function load(){{const next=new Image();
next.onload=()=>{{shown.src=next.src;ended.hidden=true}};
next.onerror=()=>{{ended.hidden=false}};
next.src='{1}?'+Date.now()}}
setInterval(load,1000)
</script></body></html>
)html";

}  // namespace

LivePicture::LivePicture(const std::string& picture, const std::string& page, const std::string& title,
                         const std::string& report)
    : picture_(picture), page_(page) {
  const std::string name = std::filesystem::path(picture).filename().string();
  replace_file(page_, fmt::format(kPage, escape_html(title), escape_html(name), escape_html(report)));
}

LivePicture::~LivePicture() {
  std::remove(picture_.c_str());
  std::remove(page_.c_str());
}

void LivePicture::offer(const std::function<void(const std::string& path)>& draw) {
  const Clock::time_point begun = Clock::now();
  if (begun < next_) return;
  try {
    draw(picture_);
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::output) throw;
  }
  const Clock::time_point ended = Clock::now();
  next_ = ended + std::max<Clock::duration>(std::chrono::seconds(2), 40 * (ended - begun));
}

}  // namespace parloc::tools
