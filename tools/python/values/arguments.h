// Python values as arguments, and C++ values as arrays.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/filter/pose_filter.h"
#include "common/math/pose.h"
#include "common/model/trajectory.h"

namespace parloc::python {

/// A pose as Python's users write it: a Pose, or three numbers in any sequence.
struct PoseLike {
  Pose pose;
};

/// Of one dimension: an array of numbers, or any sequence of them. Throws TypeError for anything else, in one
/// line that begins with `name`.
std::vector<float> floats_from(nanobind::handle source, const char* name);
std::vector<double> doubles_from(nanobind::handle source, const char* name);
/// Rows of (stamp_s, x_m, y_m, theta_rad). Likewise.
Trajectory trajectory_from(nanobind::handle source, const char* name);
/// Bytes in rows. Likewise.
nanobind::ndarray<const std::uint8_t, nanobind::ndim<2>, nanobind::c_contig, nanobind::device::cpu>
bytes_from(nanobind::handle source, const char* name);

template <class Scalar>
using Array = nanobind::ndarray<nanobind::numpy, Scalar>;
/// For properties whose arrays own what they hold.
inline constexpr auto kOwnArray = nanobind::rv_policy::automatic;

/// A vector as a numpy array without a copy, a row with `columns` numbers each (1: no second dimension): the
/// array owns it from now on.
template <class Scalar, class Row>
Array<Scalar> array_of(std::vector<Row>&& rows, std::size_t columns) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0);
  auto* kept = new std::vector<Row>(std::move(rows));
  nanobind::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<Row>*>(p); });
  const std::size_t shape[] = {kept->size(), columns};
  return {kept->data(), columns > 1 ? 2u : 1u, shape, owner};
}
static_assert(sizeof(StampedPose) == 4 * sizeof(double));
/// Rows of (stamp_s, x_m, y_m, theta_rad).
Array<double> array_of(Trajectory&& trajectory);
/// 3 x 3, a copy.
Array<double> array_of(const Covariance& covariance);

/// Lets Ctrl-C end what takes long; the GIL is held.
inline void heed_signals() {
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

}  // namespace parloc::python

namespace nanobind::detail {

template <>
struct type_caster<parloc::python::PoseLike> {
  NB_TYPE_CASTER(parloc::python::PoseLike, const_name("Pose | collections.abc.Sequence[float]"))

  bool from_python(handle source, std::uint8_t, cleanup_list*) noexcept {
    if (parloc::Pose * pose; try_cast<parloc::Pose*>(source, pose) && pose != nullptr) {
      value.pose = *pose;
      return true;
    }
    if (PyUnicode_Check(source.ptr()) || PySequence_Size(source.ptr()) != 3) return PyErr_Clear(), false;
    double v[3];
    for (Py_ssize_t k = 0; k < 3; ++k) {
      PyObject* item = PySequence_GetItem(source.ptr(), k);
      if (item != nullptr) v[k] = PyFloat_AsDouble(item);
      Py_XDECREF(item);
      if (PyErr_Occurred() != nullptr) return PyErr_Clear(), false;
    }
    value.pose = {v[0], v[1], v[2]};
    return true;
  }
  static handle from_cpp(const parloc::python::PoseLike& source, rv_policy policy, cleanup_list* list) {
    return make_caster<parloc::Pose>::from_cpp(source.pose, policy, list);
  }
};

}  // namespace nanobind::detail
