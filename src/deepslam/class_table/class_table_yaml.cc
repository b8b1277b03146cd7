#include "deepslam/class_table/class_table_yaml.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/core/yaml_quotes.h"

namespace deepslam::class_table {
namespace {

constexpr int kVersion = 5;  // of the format; older ones are read, later ones refused
constexpr double kMaxDensityKgM3 = 25'000;  // no metal is denser than 22,600 kg/m3
constexpr double kMaxSizeM = 20;  // m: no furniture is longer; a larger number is in another unit
// Aliases can make a small file huge.
constexpr std::size_t kMaxBytes = 1U << 20;
constexpr std::size_t kMaxClasses = 1000;   // against aliases; a table made by hand has some dozens
constexpr std::size_t kMaxLabels = 10'000;  // of all classes together, against aliases
constexpr int kMaxFaults = 50;              // more are not told: nobody mends as many at a time
constexpr std::string_view kHeader =
    "# Classes of objects the map may hold. `labels` are what detectors call them, `library` the "
    "classes of CAD models\n"
    "# that may stand for them, `size_m` the range of the longest side and `height_m` of the "
    "height of real ones.\n"
    "# What no detector names is none of a class whose `max_depth_m` the shorter side of its "
    "footprint "
    "exceeds.\n"
    "# What has a level face over most of it above `max_seat_height_m` is none of that class.\n"
    "# A class without labels is found by its depth alone.\n"
    "# Traits, each `true` or left out: `support_plane` is a level plane and what carries it, so "
    "that "
    "things on it are not its\n"
    "# own; `solid_inside` is closed, and solid where nobody saw into it; `yaw_free` is alike from "
    "several sides, so that\n"
    "# loops do not compare its front; `fallback` takes what fits no other class (one class at "
    "most); `built_in` is let into\n"
    "# furniture, and one thing with the piece under it; `fused_only` has the\n"
    "# shape that was measured and no prior's. `stands_on` is what such things rest on: [floor] "
    "where it is left out, or some\n"
    "# of floor, furniture, wall.\n"
    "# For other programs: `coco`, `nyu40` and `scannet200` are what those label sets call it, "
    "[id, name]; `density_kg_m3` is its\n"
    "# mass over the volume of its closed surface, hollows included, after masses and sizes of "
    "common products; `fixed: true`\n"
    "# is fixed to the building and never moves.\n";

struct FlagColumn {
  std::string_view name;
  bool ClassTraits::*flag;
};
constexpr std::array kFlagColumns = {FlagColumn{"support_plane", &ClassTraits::support_plane},
                                     FlagColumn{"solid_inside", &ClassTraits::solid_inside},
                                     FlagColumn{"yaw_free", &ClassTraits::yaw_free},
                                     FlagColumn{"fallback", &ClassTraits::fallback},
                                     FlagColumn{"built_in", &ClassTraits::built_in},
                                     FlagColumn{"fused_only", &ClassTraits::fused_only}};

struct SupportName {
  std::string_view name;
  bool Supports::*flag;
};
constexpr std::array kSupportNames = {SupportName{"floor", &Supports::floor},
                                      SupportName{"furniture", &Supports::furniture},
                                      SupportName{"wall", &Supports::wall}};

// What a class that says nothing rests on is not written.
std::string SupportsLine(const Supports& supports) {
  if (supports == Supports()) return {};
  std::vector<std::string_view> names;
  for (const SupportName& support : kSupportNames) {
    if (supports.*(support.flag)) names.push_back(support.name);
  }
  return fmt::format("    stands_on: [{}]\n", fmt::join(names, ", "));
}

struct LabelColumn {
  std::string_view name;
  std::optional<ClassLabel> CommonLabels::*label;
};
constexpr std::array kLabelColumns = {LabelColumn{"coco", &CommonLabels::coco},
                                      LabelColumn{"nyu40", &CommonLabels::nyu40},
                                      LabelColumn{"scannet200", &CommonLabels::scannet200}};

constexpr ClassTraits kSupportPlane = {.support_plane = true};
constexpr ClassTraits kTable = {.support_plane = true, .yaw_free = true};
constexpr ClassTraits kClosed = {.solid_inside = true};
constexpr ClassTraits kFallback = {.solid_inside = true, .yaw_free = true, .fallback = true};

// What a table of version 1 does not say: programs that wrote it had these traits by name.
struct NamedTraits {
  std::string_view class_name;
  ClassTraits traits;
};
constexpr std::array kTraitsOfVersion1 = {NamedTraits{"table", kTable},
                                          NamedTraits{"desk", kSupportPlane},
                                          NamedTraits{"sofa", kClosed},
                                          NamedTraits{"bed", kClosed},
                                          NamedTraits{"cabinet", kClosed},
                                          NamedTraits{"shelf", kClosed},
                                          NamedTraits{"furniture", kFallback}};

ClassTraits TraitsOfVersion1(std::string_view class_name) {
  for (const NamedTraits& known : kTraitsOfVersion1) {
    if (known.class_name == class_name) return known.traits;
  }
  return {};
}

bool IsClassName(const std::string& name) {
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

// A scalar of a YAML list that reads back as the same text.
std::string Quoted(const std::string& text) {
  const bool plain = !IsNullYaml(text) && text.back() != ' ' &&
                     std::isalpha(static_cast<unsigned char>(text.front())) != 0 &&
                     std::all_of(text.begin(), text.end(), [](unsigned char c) {
                       return std::isalnum(c) != 0 || c == '_' || c == ' ' || c == '-';
                     });
  if (plain) return text;
  return DoubleQuotedYaml(text);
}

std::string Quoted(const std::vector<std::string>& texts) {
  std::vector<std::string> quoted;
  for (const std::string& text : texts) quoted.push_back(Quoted(text));
  return fmt::format("{}", fmt::join(quoted, ", "));
}

// A value as a fault names it.
std::string Shown(const std::string& text) {
  constexpr std::size_t kMaxShown = 40;  // characters; a longer value would fill the message
  return text.size() <= kMaxShown ? text : "...";
}

// What stage `export` says of a class; what is a default is not written.
std::string LinesOfExport(const ObjectClass& c) {
  std::string lines;
  for (const LabelColumn& column : kLabelColumns) {
    const std::optional<ClassLabel>& label = c.labels_elsewhere.*(column.label);
    if (label)
      lines += fmt::format("    {}: [{}, {}]\n", column.name, label->id, Quoted(label->name));
  }
  if (c.physics.density_kg_m3 != ClassPhysics().density_kg_m3)
    lines += fmt::format("    density_kg_m3: {}\n", c.physics.density_kg_m3);
  if (c.physics.fixed) lines += "    fixed: true\n";
  return lines;
}

class TableReader {
 public:
  explicit TableReader(std::string_view name) : name_(name) {}

  void Read(const YAML::Node& root) {
    if (!root.IsMap() || !root["classes"] || !root["classes"].IsSequence()) {
      return Fault(root, "must be a map with `version` and a list `classes`");
    }
    for (const auto& item : root) {
      const std::string key = item.first.as<std::string>("");
      if (key != "version" && key != "classes")
        Fault(item.first, fmt::format("unknown key \"{}\"; known are version, classes", key));
    }
    ReadVersion(root);
    if (root["classes"].size() > kMaxClasses)
      return Fault(root["classes"], fmt::format("more than {} classes", kMaxClasses));
    for (const YAML::Node& node : root["classes"]) ReadClass(node);
    if (table.classes.empty()) Fault(root, "holds no class");
  }

  ClassTable table;
  std::string faults;

 private:
  void ReadVersion(const YAML::Node& root) {
    const YAML::Node node = root["version"];
    version_ = node ? node.as<int>(-1) : -1;
    if (version_ >= 1 && version_ <= kVersion) return;
    const bool newer = version_ > kVersion;
    Fault(node ? node : root,
          newer ? fmt::format("version is {}, written for a later deepslam; this one reads 1 to {}",
                              version_,
                              kVersion)
                : fmt::format("version must be 1 to {}", kVersion));
    version_ = kVersion;
  }

  void ReadClass(const YAML::Node& node) {
    class_ = fmt::format("class {}", table.classes.size() + 1);
    if (!node.IsMap()) return Fault(node, "must be a map");
    ObjectClass c;
    c.name = node["name"] ? node["name"].as<std::string>("") : "";
    if (!IsClassName(c.name)) {
      Fault(node, fmt::format("name \"{}\" must be lower-case letters, digits and _", c.name));
    } else {
      class_ = fmt::format("class {}", c.name);
    }
    if (version_ == 1) c.traits = TraitsOfVersion1(c.name);
    for (const auto& item : node) {
      field_ = item.first.as<std::string>("");
      ReadField(item.first, item.second, c);
    }
    field_.clear();
    CheckAmongOthers(node, c);
    table.classes.push_back(std::move(c));
    class_.clear();
  }

  void ReadField(const YAML::Node& key, const YAML::Node& node, ObjectClass& c) {
    if (field_ == "name") return;
    if (field_ == "labels") {
      c.detector_labels = Strings(node);
    } else if (field_ == "library") {
      c.library_classes = Strings(node);
    } else if (field_ == "size_m") {
      ReadRange(node, c.min_size_m, c.max_size_m);
    } else if (field_ == "height_m") {
      ReadRange(node, c.min_height_m, c.max_height_m);
    } else if (field_ == "max_depth_m") {
      ReadGreatest(key, 4, node, c.max_depth_m);
    } else if (field_ == "max_seat_height_m") {
      ReadGreatest(key, 5, node, c.max_seat_height_m);
    } else if (field_ == "colour") {
      ReadColour(node, c);
    } else if (field_ == "stands_on") {
      ReadSupports(key, node, c.traits.supports);
    } else if (!ReadColumnOfExport(key, node, c)) {
      ReadTrait(key, node, c.traits);
    }
  }

  void ReadTrait(const YAML::Node& key, const YAML::Node& node, ClassTraits& traits) {
    const auto column =
        std::find_if(kFlagColumns.begin(), kFlagColumns.end(), [this](const FlagColumn& flag) {
          return flag.name == field_;
        });
    if (column == kFlagColumns.end()) {
      const std::string unknown = std::exchange(field_, {});
      std::string known =
          "name, labels, library, size_m, height_m, max_depth_m, max_seat_height_m, colour, "
          "stands_on";
      for (const FlagColumn& flag : kFlagColumns) known += fmt::format(", {}", flag.name);
      for (const LabelColumn& label : kLabelColumns) known += fmt::format(", {}", label.name);
      known += ", density_kg_m3, fixed";
      return Fault(key, fmt::format("unknown key \"{}\"; known are {}", unknown, known));
    }
    if (IsOfVersion(key)) ReadFlag(node, traits.*(column->flag));
  }

  bool IsOfVersion(const YAML::Node& key, int since = 2) {
    if (version_ >= since) return true;
    Fault(key, fmt::format("is not of version {}; write `version: {}` above", version_, since));
    return false;
  }

  // Whether it is one of the columns for other programs, which then was read.
  bool ReadColumnOfExport(const YAML::Node& key, const YAML::Node& node, ObjectClass& c) {
    for (const LabelColumn& column : kLabelColumns) {
      if (column.name != field_) continue;
      if (IsOfVersion(key, 3)) ReadLabel(node, c.labels_elsewhere.*(column.label));
      return true;
    }
    if (field_ == "density_kg_m3") {
      if (!IsOfVersion(key, 3)) return true;
      c.physics.density_kg_m3 = node.as<double>(NAN);
      if (!(c.physics.density_kg_m3 > 0 && c.physics.density_kg_m3 <= kMaxDensityKgM3))
        Fault(node, fmt::format("must lie in (0, {}]", kMaxDensityKgM3));
      return true;
    }
    if (field_ != "fixed") return false;
    if (IsOfVersion(key, 3)) ReadFlag(node, c.physics.fixed);
    return true;
  }

  void ReadLabel(const YAML::Node& node, std::optional<ClassLabel>& label) {
    const bool is_pair = node.IsSequence() && node.size() == 2;
    label.emplace();
    if (is_pair) *label = {node[0].as<int>(-1), node[1].as<std::string>("")};
    if (!is_pair || label->id < 0 || label->name.empty())
      Fault(node, "must be [id, name], as [62, chair]");
  }

  void ReadFlag(const YAML::Node& node, bool& flag) {
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (text != "true" && text != "false")
      return Fault(node, fmt::format("is \"{}\", must be true or false", Shown(text)));
    flag = text == "true";
  }

  void ReadSupports(const YAML::Node& key, const YAML::Node& node, Supports& supports) {
    if (!IsOfVersion(key)) return;
    if (!node.IsSequence() || node.size() == 0)
      return Fault(node, "must be a list of floor, furniture, wall, one of them at least");
    supports = {.floor = false};
    for (const YAML::Node& item : node) {
      const std::string text = item.IsScalar() ? item.Scalar() : "";
      const auto known = std::find_if(kSupportNames.begin(),
                                      kSupportNames.end(),
                                      [&](const SupportName& name) { return name.name == text; });
      if (known == kSupportNames.end())
        return Fault(item, fmt::format("\"{}\" is none of floor, furniture, wall", Shown(text)));
      supports.*(known->flag) = true;
    }
  }

  void CheckAmongOthers(const YAML::Node& node, const ObjectClass& c) {
    if (!names_.insert(c.name).second) Fault(node, "stands twice; take one of them out");
    for (const std::string& label : c.detector_labels) {
      if (!labels_.insert(label).second)
        Fault(node, fmt::format("label \"{}\" belongs to another class already", label));
    }
    const ObjectClass* const other = table.Fallback();
    if (c.traits.fallback && other != nullptr) {
      Fault(node,
            fmt::format("is a fallback, as class {} is already; one class at most may be",
                        other->name));
    }
  }

  std::vector<std::string> Strings(const YAML::Node& node) {
    std::vector<std::string> strings;
    if (!node.IsSequence()) {
      Fault(node, "must be a list, as [one, two]");
      return strings;
    }
    num_labels_ += node.size();
    if (num_labels_ > kMaxLabels) {
      Fault(node, fmt::format("more than {} labels", kMaxLabels));
      return strings;
    }
    for (const YAML::Node& item : node) strings.push_back(item.as<std::string>(""));
    return strings;
  }

  void ReadRange(const YAML::Node& node, double& low, double& high) {
    if (node.IsSequence() && node.size() == 2) {
      low = node[0].as<double>(NAN);
      high = node[1].as<double>(NAN);
      if (low > 0 && low <= high && high <= kMaxSizeM) return;
    }
    Fault(
        node,
        fmt::format("must be [least, greatest] in metres, 0 < least <= greatest <= {}", kMaxSizeM));
  }

  void ReadGreatest(const YAML::Node& key, int since, const YAML::Node& node, double& max_m) {
    if (!IsOfVersion(key, since)) return;
    max_m = node.as<double>(NAN);
    if (!(max_m > 0 && max_m <= kMaxSizeM))
      Fault(node, fmt::format("must lie in (0, {}]", kMaxSizeM));
  }

  void ReadColour(const YAML::Node& node, ObjectClass& c) {
    if (!node.IsSequence() || node.size() != 3) return Fault(node, "must be [red, green, blue]");
    for (std::size_t i = 0; i < 3; ++i) {
      c.colour_rgb[i] = node[i].as<int>(-1);
      if (c.colour_rgb[i] < 0 || c.colour_rgb[i] > 255)
        return Fault(node, "red, green and blue must lie in [0, 255]");
    }
  }

  void Fault(const YAML::Node& node, std::string_view what) {
    if (++num_faults_ > kMaxFaults) return;
    std::string place = class_;
    if (!field_.empty()) place += ", " + field_;
    if (!place.empty()) place += ": ";
    faults += fmt::format(
        "{}{}:{}: {}{}", faults.empty() ? "" : "\n", name_, node.Mark().line + 1, place, what);
  }

  std::string name_;
  int version_ = kVersion;
  std::string class_;  // that is read, in words; empty outside
  std::string field_;  // of it; empty where a fault is of the class as a whole
  std::size_t num_labels_ = 0;
  int num_faults_ = 0;
  std::set<std::string> names_;
  std::set<std::string> labels_;
};

}  // namespace

std::string EncodeClassTable(const ClassTable& table) {
  std::string text = fmt::format("{}version: {}\nclasses:\n", kHeader, kVersion);
  for (const ObjectClass& c : table.classes) {
    text += fmt::format("  - name: {}\n    labels: [{}]\n    library: [{}]\n",
                        c.name,
                        Quoted(c.detector_labels),
                        Quoted(c.library_classes));
    text += fmt::format("    size_m: [{}, {}]\n    height_m: [{}, {}]\n",
                        c.min_size_m,
                        c.max_size_m,
                        c.min_height_m,
                        c.max_height_m);
    if (std::isfinite(c.max_depth_m)) text += fmt::format("    max_depth_m: {}\n", c.max_depth_m);
    if (std::isfinite(c.max_seat_height_m))
      text += fmt::format("    max_seat_height_m: {}\n", c.max_seat_height_m);
    text += fmt::format("    colour: [{}]\n", fmt::join(c.colour_rgb, ", "));
    text += SupportsLine(c.traits.supports);
    for (const FlagColumn& column : kFlagColumns) {
      if (c.traits.*(column.flag)) text += fmt::format("    {}: true\n", column.name);
    }
    text += LinesOfExport(c);
  }
  return text;
}

Result<ClassTable> DecodeClassTable(std::string_view text, std::string_view name) {
  if (text.size() > kMaxBytes) {
    return InvalidConfig(fmt::format("{}: {} bytes are too many for a table of classes; at most {}",
                                     name,
                                     text.size(),
                                     kMaxBytes));
  }
  try {
    TableReader reader(name);
    reader.Read(YAML::Load(std::string(text)));
    if (!reader.faults.empty()) return InvalidConfig(reader.faults);
    return std::move(reader.table);
  } catch (const YAML::Exception& e) {
    return InvalidConfig(fmt::format("{}:{}: {}", name, e.mark.line + 1, e.msg));
  }
}

}  // namespace deepslam::class_table
