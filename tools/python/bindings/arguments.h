// Python values as arguments, and C++ values as arrays.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "common/math/pose.h"

namespace parloc::python {

/// A pose as Python's users write it: a Pose, or three numbers in any sequence.
struct PoseLike {
  Pose pose;
};

/// A vector as a numpy array of `shape`, without a copy: the array owns it from now on.
template <class Scalar, class Row>
nanobind::ndarray<nanobind::numpy, Scalar> array_of(std::vector<Row>&& rows, std::size_t columns) {
  static_assert(sizeof(Row) % sizeof(Scalar) == 0);
  auto* kept = new std::vector<Row>(std::move(rows));
  nanobind::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<Row>*>(p); });
  const std::size_t shape[] = {kept->size(), columns};
  return {kept->data(), columns > 1 ? 2u : 1u, shape, owner};
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
