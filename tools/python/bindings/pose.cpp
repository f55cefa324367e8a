// Poses in the plane.
#include "common/math/pose.h"

#include <fmt/format.h>
#include <nanobind/operators.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"

namespace parloc::python {

namespace nb = nanobind;
using namespace nb::literals;

void bind_pose(nb::module_& m) {
  nb::class_<Pose> type(
      m, "Pose",
      "A pose in the plane, or the rigid transform T_parent_child that it stands for. Unpacks "
      "into (x, y, theta), and wherever a pose is wanted three numbers will do.");
  type.attr("__hash__") = nb::none();  // it can change
  type.def(nb::init<double, double, double>(), "x_m"_a = 0.0, "y_m"_a = 0.0, "theta_rad"_a = 0.0)
      .def(
          "__init__", [](Pose* self, const PoseLike& other) { new (self) Pose(other.pose); }, "pose"_a)
      .def_rw("x_m", &Pose::x_m, "Place along x [m].")
      .def_rw("y_m", &Pose::y_m, "Place along y [m].")
      .def_rw("theta_rad", &Pose::theta_rad, "Heading, counter-clockwise, 0 along +x [rad].")
      .def(
          "__iter__", [](const Pose& p) { return nb::iter(nb::make_tuple(p.x_m, p.y_m, p.theta_rad)); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"))
      .def("__len__", [](const Pose&) { return 3; })
      .def("__getitem__",
           [](const Pose& p, Py_ssize_t k) {
             if (k < -3 || k > 2) throw nb::index_error("a pose has x, y and theta");
             const double v[] = {p.x_m, p.y_m, p.theta_rad};
             return v[(k + 3) % 3];
           })
      .def(
          "__eq__",
          [](const Pose& a, const Pose& b) {
            return a.x_m == b.x_m && a.y_m == b.y_m && a.theta_rad == b.theta_rad;
          },
          nb::is_operator(), nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def("__repr__",
           [](const Pose& p) { return fmt::format("Pose({}, {}, {})", p.x_m, p.y_m, p.theta_rad); })
      .def("__getstate__", [](const Pose& p) { return std::tuple(p.x_m, p.y_m, p.theta_rad); })
      .def("__setstate__",
           [](Pose& p, const std::tuple<double, double, double>& v) {
             new (&p) Pose{std::get<0>(v), std::get<1>(v), std::get<2>(v)};
           })
      .def(
          "__matmul__", [](const Pose& a, const Pose& b) { return compose(a, b); }, "b"_a, nb::is_operator(),
          "Pose b, given in the frame of this one, in the parent frame of this one: T_a_b @ T_b_c = T_a_c.")
      .def(
          "inverse", [](const Pose& p) { return inverse(p); }, "pose.inverse() @ pose is the identity.");
}

}  // namespace parloc::python
