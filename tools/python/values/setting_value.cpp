#include "tools/python/values/setting_value.h"

#include <fmt/format.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/error.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;

std::string text_of(nb::handle value) {
  return printable(nb::cast<std::string>(nb::str(value)));
}

nb::builtin_exception wrong_type(const Setting& setting, nb::handle value) {
  return nb::type_error(fmt::format("{} must be {}, got {} {}", setting.name(), allowed_text(setting),
                                    nb::cast<std::string>(nb::handle(Py_TYPE(value.ptr())).attr("__name__")),
                                    text_of(value))
                            .c_str());
}

Error not_allowed(const Setting& setting, nb::handle value) {
  return Error(ErrorKind::config,
               fmt::format("{} must be {}, got {}", setting.name(), allowed_text(setting), text_of(value)));
}

template <class Number>
Number number_of(const Setting& setting, nb::handle value) {
  if (PyBool_Check(value.ptr())) throw wrong_type(setting, value);
  if constexpr (std::is_floating_point_v<Number>) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (number == -1.0 && PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      throw wrong_type(setting, value);
    }
    return number;
  } else {
    const nb::object whole = nb::steal(PyNumber_Index(value.ptr()));
    if (!whole.is_valid()) {
      PyErr_Clear();
      throw wrong_type(setting, value);
    }
    Number number{};
    if (!nb::try_cast(whole, number)) throw not_allowed(setting, value);
    return number;
  }
}

/// Sets it, looks whether it may be that, and puts the old value back if not.
template <class Value>
void set_checked(const Setting& setting, const Slot<Value>& slot, const Value& value) {
  const Value* now = slot.get();
  const Value old = now != nullptr ? *now : value;
  slot.set(value);
  const std::string message = limits_message(setting);
  if (message.empty()) return;
  slot.set(old);
  throw Error(ErrorKind::config, message);
}

template <class Number>
void put(const Setting& setting, const NumberSetting<Number>& number, nb::handle value) {
  set_checked(setting, number.slot, number_of<Number>(setting, value));
}

void put(const Setting& setting, const FlagSetting& flag, nb::handle value) {
  if (!PyBool_Check(value.ptr())) throw wrong_type(setting, value);
  flag.set(value.ptr() == Py_True);
}

void put(const Setting& setting, const TextSetting& text, nb::handle value) {
  if (!nb::isinstance<nb::str>(value)) throw wrong_type(setting, value);
  set_checked(setting, Slot<std::string>(*text.text), nb::cast<std::string>(value));
}

void put(const Setting& setting, const ChoiceSetting& choice, nb::handle value) {
  if (!nb::isinstance<nb::str>(value)) throw wrong_type(setting, value);
  const std::string name = nb::cast<std::string>(value);
  for (std::size_t k = 0; k < choice.names.size(); ++k)
    if (name == choice.names[k].first) return choice.choose(k);
  throw not_allowed(setting, value);
}

void put(const Setting& setting, const IntervalsSetting& list, nb::handle value) {
  std::vector<std::pair<double, double>> intervals;
  if (!nb::try_cast(value, intervals)) throw wrong_type(setting, value);
  const auto old = list.get();
  list.set(intervals);
  const std::string message = limits_message(setting);
  if (message.empty()) return;
  list.set(old);
  throw Error(ErrorKind::config, message);
}

template <class Value>
nb::object taken(const Slot<Value>& slot) {
  return slot.get() != nullptr ? nb::cast(*slot.get()) : nb::none();
}
template <class Number>
nb::object take(const NumberSetting<Number>& number) {
  return taken(number.slot);
}
nb::object take(const FlagSetting& flag) {
  return taken(flag);
}
nb::object take(const TextSetting& text) {
  return nb::cast(*text.text);
}
nb::object take(const ChoiceSetting& choice) {
  return choice.name() != nullptr ? nb::cast(std::string(choice.name())) : nb::none();
}
nb::object take(const IntervalsSetting& list) {
  return nb::cast(list.get());
}

struct TypeName {
  template <class Number>
  std::string operator()(const NumberSetting<Number>&) const {
    return std::is_floating_point_v<Number> ? "float" : "int";
  }
  std::string operator()(const FlagSetting&) const { return "bool"; }
  std::string operator()(const TextSetting&) const { return "str"; }
  std::string operator()(const ChoiceSetting&) const { return "str"; }
  std::string operator()(const IntervalsSetting&) const { return "list[tuple[float, float]]"; }
};

}  // namespace

nb::object value_of(const Setting& setting) {
  return std::visit([](const auto& value) { return take(value); }, setting.value);
}

void assign(const Setting& setting, nb::handle value) {
  std::visit([&](const auto& target) { put(setting, target, value); }, setting.value);
}

std::string python_type(const Setting& setting) {
  return std::visit(TypeName(), setting.value);
}

std::string python_doc(const Setting& setting) {
  return fmt::format("{} ({}).", setting.doc, allowed_text(setting));
}

}  // namespace parloc::python
