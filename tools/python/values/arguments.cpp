#include "tools/python/values/arguments.h"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <string>

namespace parloc::python {
namespace {

namespace nb = nanobind;

std::string text_of(const nb::object& value) {
  return nb::cast<std::string>(nb::str(value));
}

std::string described(nb::handle source) {
  const std::string type = nb::cast<std::string>(nb::handle(Py_TYPE(source.ptr())).attr("__name__"));
  if (!nb::hasattr(source, "shape") || !nb::hasattr(source, "dtype")) return type;
  return fmt::format("{} of {} with shape {}", type, text_of(source.attr("dtype")),
                     text_of(source.attr("shape")));
}

/// The array itself if it is one of these, else what numpy makes of it. `safe`: no number changes on the way.
template <class Wanted>
Wanted array_from(nb::handle source, const char* dtype, const char* name, const char* expected, bool safe) {
  Wanted array;
  if (nb::try_cast<Wanted>(source, array, false)) return array;
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    nb::object made = numpy.attr("asarray")(source);
    const bool kept = !safe || text_of(made.attr("dtype")) == dtype;
    if (kept) made = numpy.attr("ascontiguousarray")(made, dtype);
    if (kept && nb::try_cast<Wanted>(made, array, false)) return array;
  } catch (const nb::python_error&) {  // no numbers: said below
  }
  throw nb::type_error(fmt::format("{}: expected {}, got {}", name, expected, described(source)).c_str());
}

template <class Scalar>
std::vector<Scalar> vector_from(nb::handle source, const char* dtype, const char* name) {
  using Wanted = nb::ndarray<const Scalar, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
  const Wanted array = array_from<Wanted>(source, dtype, name, "numbers in one dimension", false);
  return std::vector<Scalar>(array.data(), array.data() + array.shape(0));
}

}  // namespace

std::vector<float> floats_from(nb::handle source, const char* name) {
  return vector_from<float>(source, "float32", name);
}

std::vector<double> doubles_from(nb::handle source, const char* name) {
  return vector_from<double>(source, "float64", name);
}

Trajectory trajectory_from(nb::handle source, const char* name) {
  using Wanted = nb::ndarray<const double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
  const Wanted array =
      array_from<Wanted>(source, "float64", name, "rows of (stamp_s, x_m, y_m, theta_rad)", false);
  Trajectory trajectory;
  trajectory.reserve(array.shape(0));
  for (std::size_t k = 0; k < array.shape(0); ++k)
    trajectory.push_back({array(k, 0), {array(k, 1), array(k, 2), array(k, 3)}});
  return trajectory;
}

nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu> bytes_from(nb::handle source,
                                                                                       const char* name) {
  using Wanted = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
  return array_from<Wanted>(source, "uint8", name, "uint8 of shape (height, width)", true);
}

Array<double> array_of(Trajectory&& trajectory) {
  return array_of<double>(std::move(trajectory), 4);
}

Array<double> array_of(const Covariance& covariance) {
  auto* kept = new Covariance(covariance);
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<Covariance*>(p); });
  return {kept->v, {3, 3}, owner};
}

}  // namespace parloc::python
