// parloc::Error as the exceptions of tools/python/parloc/errors.py.
#include "common/error.h"

#include <exception>

#include "tools/python/bindings/bindings.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;

const char* class_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::usage:
      return "UsageError";
    case ErrorKind::input:
      return "InputError";
    case ErrorKind::config:
      return "ConfigError";
    case ErrorKind::output:
      return "OutputError";
    case ErrorKind::backend:
      return "BackendError";
    case ErrorKind::internal:
      break;
  }
  return "Error";
}

}  // namespace

void bind_errors(nb::module_&) {
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const Error& e) {
      const nb::object type = nb::module_::import_("parloc.errors").attr(class_of(e.kind()));
      PyErr_SetString(type.ptr(), e.what());
    }
  });
}

}  // namespace parloc::python
