// Configurations: every setting of the table as an attribute, in the groups that files have.
#include "tools/python/values/config_box.h"

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/model/lidar.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/setting_value.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

/// As many as the table has, which is checked when the module is loaded: each is a class of its own, so that
/// editors know its attributes.
constexpr std::size_t kGroups = 12;

/// Of one group of settings: reads and writes those of the Config that it belongs to.
template <std::size_t K>
struct Group {
  nb::object config;
};
/// Of one LiDAR.
struct Lidar {
  nb::object config;
  std::string name;
};
struct Lidars {
  nb::object config;
};

ConfigBox& box_of(nb::handle config) {
  return nb::cast<ConfigBox&>(config);
}

/// A model brings its defaults, as it does in a file.
void set(ConfigBox& box, const Setting& setting, nb::handle value) {
  const SensorModel before = box.config.sensor.model;
  assign(setting, value);
  if (box.config.sensor.model != before) box.config.sensor = default_sensor(box.config.sensor.model);
}

std::vector<std::string> names_in(const ConfigBox& box, const std::string& group) {
  std::vector<std::string> names;
  for (const Setting& setting : box.table.all)
    if (setting.group == group) names.push_back(setting.key);
  if (!group.empty()) return names;
  for (const SettingGroup& known : box.table.groups) names.push_back(known.name);
  names.push_back(box.table.named->group.name);
  return names;
}

std::string unknown(const std::string& what, const std::string& name, const std::vector<std::string>& names) {
  return fmt::format("{} has no setting '{}'; the nearest is '{}'", what, printable(name),
                     names.empty() ? "" : nearest_name(name, names));
}

const Setting* find(const ConfigBox& box, const std::string& group, const std::string& key) {
  for (const Setting& setting : box.table.all)
    if (setting.group == group && setting.key == key) return &setting;
  return nullptr;
}

/// The values of a dict to a group, the model first, since it decides other defaults.
void set_group(ConfigBox& box, const std::string& group, nb::handle values) {
  if (!nb::isinstance<nb::dict>(values))
    throw nb::type_error(fmt::format("{}: expected a dict of settings", group).c_str());
  const auto dict = nb::borrow<nb::dict>(values);
  const auto set_one = [&](nb::handle key, nb::handle value) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const Setting* setting = find(box, group, name);
    if (setting == nullptr) throw Error(ErrorKind::config, unknown(group, name, names_in(box, group)));
    set(box, *setting, value);
  };
  if (dict.contains("model")) set_one(nb::str("model"), dict["model"]);
  for (const auto& [key, value] : dict) set_one(key, value);
}

void set_lidar(ConfigBox& box, const std::string& name, nb::handle values) {
  if (!is_setting_name(name))
    throw Error(ErrorKind::config,
                fmt::format("lidars: '{}' is no name of a LiDAR: {}", printable(name), kExpectedName));
  if (!nb::isinstance<nb::dict>(values))
    throw nb::type_error(fmt::format("lidars.{}: expected a dict of settings", name).c_str());
  ConfigBox changed(box.config);  // what is wrong changes nothing
  std::erase_if(changed.config.lidars, [&](const LidarConfig& lidar) { return lidar.name == name; });
  const std::vector<Setting> settings = changed.table.named->of(name);
  for (const auto& [key, value] : nb::borrow<nb::dict>(values)) {
    const std::string wanted = nb::cast<std::string>(nb::str(key));
    const auto setting =
        std::find_if(settings.begin(), settings.end(), [&](const Setting& s) { return s.key == wanted; });
    if (setting == settings.end()) {
      std::vector<std::string> names;
      for (const Setting& s : settings) names.push_back(s.key);
      throw Error(ErrorKind::config, unknown("lidars." + name, wanted, names));
    }
    assign(*setting, value);
  }
  box.config.lidars = changed.config.lidars;
}

void set_lidars(ConfigBox& box, nb::handle values) {
  if (!nb::isinstance<nb::dict>(values)) throw nb::type_error("lidars: expected a dict of LiDARs by name");
  box.config.lidars.clear();
  for (const auto& [name, lidar] : nb::borrow<nb::dict>(values))
    set_lidar(box, nb::cast<std::string>(nb::str(name)), lidar);
}

void set_all(ConfigBox& box, const nb::kwargs& values) {
  for (const auto& [key, value] : values) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const auto& groups = box.table.groups;
    if (name == box.table.named->group.name) {
      set_lidars(box, value);
    } else if (std::any_of(groups.begin(), groups.end(), [&](const auto& g) { return g.name == name; })) {
      set_group(box, name, value);
    } else if (const Setting* setting = find(box, "", name)) {
      set(box, *setting, value);
    } else {
      throw Error(ErrorKind::config, unknown("Config", name, names_in(box, "")));
    }
  }
}

/// "particles" or "sensor.model".
const Setting& setting_named(const ConfigBox& box, const std::string& name) {
  std::vector<std::string> names;
  for (const Setting& setting : box.table.all) {
    if (setting.name() == name) return setting;
    names.push_back(setting.name());
  }
  throw nb::key_error(unknown("Config", name, names).c_str());
}

/// What differs from the defaults, to be typed again.
std::string short_text(const ConfigBox& box) {
  const ConfigBox defaults;
  std::string text;
  for (std::size_t k = 0; k < box.table.all.size(); ++k) {
    const Setting& setting = box.table.all[k];
    if (value_text(setting) == value_text(defaults.table.all[k])) continue;
    text += fmt::format("{}{}={}", text.empty() ? "" : ", ", setting.name(),
                        nb::cast<std::string>(nb::repr(value_of(setting))));
  }
  if (!box.config.lidars.empty())
    text += fmt::format("{}{} LiDARs", text.empty() ? "" : ", ", box.config.lidars.size());
  return fmt::format("<parloc.Config {}>", text.empty() ? "of defaults" : text);
}

// ---- attributes
// ------------------------------------------------------------------------------------------------------

/// No misspelt name is taken silently, and none is without its nearest.
template <class Class, class Names>
void name_the_nearest(Class& type, const std::string& what, Names names) {
  const auto complain = [what, names](nb::handle self, const std::string& name) {
    const bool setting = name.rfind("_", 0) != 0;
    throw nb::attribute_error(setting ? unknown(what, name, names(self)).c_str() : name.c_str());
  };
  type.def("__getattr__", complain);
  type.def("__setattr__", [complain](nb::handle self, const std::string& name, nb::object value) {
    if (!nb::hasattr(self.type(), name.c_str())) complain(self, name);
    if (PyObject_GenericSetAttr(self.ptr(), nb::str(name.c_str()).ptr(), value.ptr()) != 0)
      throw nb::python_error();
  });
}

/// The property of a setting. `settings(self)` is the box; `k` the setting's place in its table.
template <class Class, class Box>
void add_property(Class& type, std::size_t k, const Setting& setting, Box box) {
  const std::string value = python_type(setting);
  const std::string getter = fmt::format("def {}(self) -> {}", setting.key, value);
  const std::string setter = fmt::format("def {}(self, value: {}) -> None", setting.key, value);
  type.def_prop_rw(
      setting.key.c_str(), [k, box](nb::handle self) { return value_of(box(self).table.all[k]); },
      [k, box](nb::handle self, nb::object v) { set(box(self), box(self).table.all[k], v); },
      nb::for_getter(nb::sig(getter.c_str())), nb::for_setter(nb::sig(setter.c_str())),
      python_doc(setting).c_str());
}

template <std::size_t K>
void bind_group(nb::module_& m, nb::class_<ConfigBox>& config, const Settings& table) {
  const SettingGroup& group = table.groups[K];
  std::string class_name = group.name;
  class_name[0] = static_cast<char>(class_name[0] - 'a' + 'A');
  nb::class_<Group<K>> type(m, (class_name + "Settings").c_str(), group.doc.c_str());
  const auto box = [](nb::handle self) -> ConfigBox& { return box_of(nb::cast<Group<K>&>(self).config); };
  for (std::size_t k = 0; k < table.all.size(); ++k)
    if (table.all[k].group == group.name) add_property(type, k, table.all[k], box);
  name_the_nearest(type, group.name,
                   [name = group.name, box](nb::handle self) { return names_in(box(self), name); });
  config.def_prop_rw(
      group.name.c_str(), [](nb::handle_t<ConfigBox> self) { return Group<K>{nb::borrow(self)}; },
      [name = group.name](ConfigBox& self, nb::dict values) { set_group(self, name, values); },
      fmt::format("{} A dict that is assigned changes the settings that it names.", group.doc).c_str());
}

template <std::size_t... K>
void bind_groups(nb::module_& m, nb::class_<ConfigBox>& config, const Settings& table,
                 std::index_sequence<K...>) {
  if (table.groups.size() != sizeof...(K)) throw std::logic_error("kGroups is not the number of groups");
  (bind_group<K>(m, config, table), ...);
}

// ---- LiDARs
// ----------------------------------------------------------------------------------------------------------

std::vector<std::string> lidar_names(const ConfigBox& box) {
  return box.table.named->names();
}

Setting lidar_setting(const Lidar& lidar, const std::string& key) {
  const ConfigBox& box = box_of(lidar.config);
  if (find_lidar(box.config.lidars, lidar.name) == nullptr)
    throw nb::key_error(fmt::format("there is no LiDAR '{}' any more", lidar.name).c_str());
  for (const Setting& setting : box.table.named->of(lidar.name))
    if (setting.key == key) return setting;
  throw std::logic_error("a LiDAR without the setting " + key);
}

void bind_lidars(nb::module_& m, nb::class_<ConfigBox>& config, const Settings& table) {
  nb::class_<Lidar> lidar(
      m, "LidarSettings",
      "What the log does not say of one LiDAR, or says wrongly; None is as the log says.");
  std::vector<std::string> keys;
  for (const Setting& setting : table.named->example) {
    const std::string key = setting.key, value = python_type(setting) + " | None";
    lidar.def_prop_rw(
        key.c_str(), [key](const Lidar& self) { return value_of(lidar_setting(self, key)); },
        [key](const Lidar& self, nb::object v) {
          Config& held = box_of(self.config).config;
          const std::vector<LidarConfig> before = held.lidars;
          try {
            assign(lidar_setting(self, key), v);
          } catch (...) {
            held.lidars = before;
            throw;
          }
        },
        nb::for_getter(nb::sig(fmt::format("def {}(self) -> {}", key, value).c_str())),
        nb::for_setter(nb::sig(fmt::format("def {}(self, value: {}) -> None", key, value).c_str())),
        python_doc(setting).c_str());
    keys.push_back(key);
  }
  name_the_nearest(lidar, "a LiDAR", [keys](nb::handle) { return keys; });

  const auto has = [](const Lidars& self, const std::string& name) {
    const auto names = lidar_names(box_of(self.config));
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  nb::class_<Lidars>(m, "Lidars", "Settings of LiDARs by the name that the log has for them, as a dict.")
      .def("__len__", [](const Lidars& self) { return lidar_names(box_of(self.config)).size(); })
      .def(
          "__iter__", [](const Lidars& self) { return nb::iter(nb::cast(lidar_names(box_of(self.config)))); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"))
      .def("__contains__", has)
      .def("__getitem__",
           [has](const Lidars& self, const std::string& name) {
             if (!has(self, name)) throw nb::key_error(name.c_str());
             return Lidar{self.config, name};
           })
      .def("__setitem__", [](const Lidars& self, const std::string& name,
                             nb::dict values) { set_lidar(box_of(self.config), name, values); })
      .def("__delitem__", [has](const Lidars& self, const std::string& name) {
        if (!has(self, name)) throw nb::key_error(name.c_str());
        std::erase_if(box_of(self.config).config.lidars,
                      [&](const LidarConfig& one) { return one.name == name; });
      });
  config.def_prop_rw(
      "lidars", [](nb::handle_t<ConfigBox> self) { return Lidars{nb::borrow(self)}; },
      [](ConfigBox& self, nb::dict values) { set_lidars(self, values); },
      "What logs do not say of their LiDARs, by name: config.lidars['front'] = {'x': 0.2, 'upside_down': "
      "True}.");
}

ConfigBox* new_box(Config config) {
  return new ConfigBox(std::move(config));
}

}  // namespace

void bind_config(nb::module_& m) {
  nb::class_<ConfigBox> config(
      m, "Config",
      "Every setting that there is, for all filters, with its default: what `parloc config` prints. Settings "
      "of "
      "groups are attributes of the group: config.sensor.sigma_hit. Assigning sensor.model gives the sensor "
      "the "
      "defaults of that model. Equal if all settings are; can be pickled and copied; str() is the YAML.");
  config
      .def(
          "__init__",
          [](ConfigBox* self, const nb::kwargs& settings) {
            new (self) ConfigBox();
            try {
              set_all(*self, settings);
            } catch (...) {
              self->~ConfigBox();
              throw;
            }
          },
          "settings"_a, nb::sig("def __init__(self, **settings: object) -> None"),
          "Config(particles=500, sensor={'model': 'beam'}): settings over the defaults, those of groups as "
          "dicts. "
          "Raises ConfigError for an unknown setting, naming the nearest, or one out of its limits; "
          "TypeError.")
      .def_static(
          "from_yaml",
          [](const std::string& text, const std::string& name, const ConfigBox* base) {
            return new_box(config_from_text(text, name, config_or_default(base)));
          },
          "text"_a, "name"_a = "the text", "base"_a = nb::none(), nb::rv_policy::take_ownership,
          "From the text of a configuration file, parloc's or nav2's, over `base` (the defaults). `name` "
          "stands "
          "for the file in messages. Raises ConfigError.")
      .def(
          "to_yaml", [](const ConfigBox& self) { return config_to_yaml(self.config); },
          "All settings, each with a comment that explains it.")
      .def(
          "validate", [](const ConfigBox& self) { parloc::validate(self.config); },
          "Raises ConfigError if settings contradict each other; every filter does this.")
      .def(
          "copy", [](const ConfigBox& self) { return new_box(self.config); }, nb::rv_policy::take_ownership,
          "An independent copy.")
      .def("__getitem__",
           [](const ConfigBox& self, const std::string& name) { return value_of(setting_named(self, name)); })
      .def("__setitem__", [](ConfigBox& self, const std::string& name,
                             nb::object value) { set(self, setting_named(self, name), value); })
      .def(
          "names",
          [](const ConfigBox& self) {
            std::vector<std::string> names;
            for (const Setting& setting : self.table.all) names.push_back(setting.name());
            return names;
          },
          "Names of all settings but those of LiDARs: 'particles', 'sensor.model', as config[name] takes "
          "them.")
      .def(
          "__eq__",
          [](const ConfigBox& a, const ConfigBox& b) {
            return config_to_yaml(a.config) == config_to_yaml(b.config);
          },
          nb::is_operator(), nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def("__str__", [](const ConfigBox& self) { return config_to_yaml(self.config); })
      .def("__repr__", &short_text)
      .def("__getstate__", [](const ConfigBox& self) { return config_to_yaml(self.config); })
      .def("__setstate__", [](ConfigBox* self, const std::string& text) {
        new (self) ConfigBox(config_from_text(text, "a pickled Config"));
      });
  config.attr("__hash__") = nb::none();  // it can change
  const ConfigBox defaults;
  for (std::size_t k = 0; k < defaults.table.all.size(); ++k)
    if (defaults.table.all[k].group.empty())
      add_property(config, k, defaults.table.all[k],
                   [](nb::handle self) -> ConfigBox& { return box_of(self); });
  bind_groups(m, config, defaults.table, std::make_index_sequence<kGroups>());
  bind_lidars(m, config, defaults.table);
  name_the_nearest(config, "Config", [](nb::handle self) { return names_in(box_of(self), ""); });
  m.def(
      "read_config", [](const std::filesystem::path& path) { return new_box(read_config(path.string())); },
      "path"_a, nb::rv_policy::take_ownership,
      "Reads a configuration: parloc's YAML, or the parameters of nav2's amcl, which are translated. Raises "
      "ConfigError, which names file and line.");
}

}  // namespace parloc::python
