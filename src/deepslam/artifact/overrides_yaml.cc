#include "deepslam/artifact/overrides_yaml.h"

#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/artifact/json_visitor.h"

namespace deepslam::artifact {
namespace {

constexpr int kVersion = 1;         // of the format; raised when its keys change
constexpr double kMaxHeightM = 10;  // m, of the camera above the floor: no room is higher
// Aliases can make a small file huge: nobody corrects as much by hand.
constexpr std::size_t kMaxBytes = 1U << 20;
// Corrections of all kinds; aliases cannot make more of a small file.
constexpr int kMaxItems = 100'000;
constexpr int kMaxFaults = 50;               // more are not told: nobody mends as many at a time
constexpr std::size_t kMaxClassBytes = 256;  // of a name; aliases repeat it
constexpr JsonFormat kAppliedFormat{"deepslam/overrides", 1};

void DescribeApplied(JsonVisitor& visitor, std::vector<std::string>& applied) {
  visitor.Field("applied", applied);
}

int Line(const YAML::Node& node) { return node.Mark().line + 1; }

class OverridesReader {
 public:
  explicit OverridesReader(std::string_view name) { overrides.file = name; }

  void Read(const YAML::Node& root) {
    if (root.IsNull()) return;  // nothing but comments
    if (!root.IsMap()) return Fault(root, "must be a map");
    for (const auto& item : root) {
      const std::string key = item.first.as<std::string>("");
      const YAML::Node& value = item.second;
      if (key == "version") {
        if (value.as<int>(-1) != kVersion)
          Fault(value, fmt::format("version must be {}", kVersion));
      } else if (key == "drop") {
        ForItems(value, [&](const YAML::Node& node) { ReadDrop(node); });
      } else if (key == "merge") {
        ForItems(value, [&](const YAML::Node& node) { ReadMerge(node); });
      } else if (key == "split") {
        ForItems(value, [&](const YAML::Node& node) { ReadSplit(node); });
      } else if (key == "relabel") {
        ReadTexts(value, overrides.relabel, overrides.named);
      } else if (key == "choose") {
        ReadTexts(value, overrides.choose, overrides.named_choices);
      } else if (key == "ground") {
        ReadGround(value);
      } else {
        Fault(item.first,
              fmt::format("unknown key \"{}\"; known are version, drop, merge, split, relabel, "
                          "choose, ground",
                          key));
      }
    }
  }

  Overrides overrides;
  std::string faults;

 private:
  template <typename Visitor>
  void ForItems(const YAML::Node& node, Visitor visit) {
    if (node.IsNull()) return;
    if (!node.IsSequence()) return Fault(node, "must be a list");
    for (const YAML::Node& item : node) {
      if (TooMany(node)) return;
      visit(item);
    }
  }

  bool TooMany(const YAML::Node& node) {
    if (++num_items_ == kMaxItems + 1) Fault(node, fmt::format("more than {} entries", kMaxItems));
    return num_items_ > kMaxItems;
  }

  // 4, or chair_04, which is added to `named`.
  ObjectId ReadObject(const YAML::Node& node, std::vector<NamedObject>& named) {
    const std::string text = node.IsScalar() ? node.as<std::string>("") : std::string();
    const std::size_t underscore = text.rfind('_');
    const bool has_class = underscore != std::string::npos;
    const std::string class_name = has_class ? text.substr(0, underscore) : std::string();
    const std::string digits = has_class ? text.substr(underscore + 1) : text;
    int value = -1;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error != std::errc() || end != digits.data() + digits.size() || digits.empty() ||
        value < 0 || value > kMaxId || (has_class && class_name.empty()) ||
        class_name.size() > kMaxClassBytes) {
      Fault(node,
            fmt::format("\"{:.100}\" is no object: write its id (4) or its name (chair_04)", text));
      return ObjectId{0};
    }
    if (has_class) named.push_back({ObjectId{value}, class_name, Line(node)});
    return ObjectId{value};
  }
  ObjectId ReadObject(const YAML::Node& node) { return ReadObject(node, overrides.named); }

  void Once(std::set<int>& seen, ObjectId object, const YAML::Node& node, std::string_view what) {
    if (!seen.insert(object.value).second) {
      Fault(node, fmt::format("object {} stands twice in {}", object.value, what));
    }
  }

  void ReadDrop(const YAML::Node& node) {
    overrides.drop.push_back({ReadObject(node), Line(node)});
    Once(dropped_, overrides.drop.back().object, node, "drop");
  }

  void ReadMerge(const YAML::Node& node) {
    if (!node.IsSequence() || node.size() < 2) {
      return Fault(node, "must be a list of two or more objects, the first of which stays");
    }
    MergeOverride merge{ReadObject(node[0]), {}, Line(node)};
    Once(merged_, merge.kept, node, "merge");
    for (std::size_t n = 1; n < node.size() && !TooMany(node); ++n) {
      merge.merged.push_back(ReadObject(node[n]));
      Once(merged_, merge.merged.back(), node, "merge");
    }
    overrides.merge.push_back(std::move(merge));
  }

  void ReadSplit(const YAML::Node& node) {
    if (!node.IsMap()) return Fault(node, "must be a map {object: ..., at_frames: [...]}");
    SplitOverride split;
    split.line = Line(node);
    for (const auto& item : node) {
      const std::string key = item.first.as<std::string>("");
      if (key == "object") {
        split.object = ReadObject(item.second);
      } else if (key == "at_frames") {
        ForItems(item.second, [&](const YAML::Node& frame) {
          const int value = frame.as<int>(-1);
          const bool ascends = split.at_frames.empty() || value > split.at_frames.back().value;
          if (value < 0 || !ascends) Fault(frame, "frames must be whole numbers, ascending");
          split.at_frames.push_back(FrameIdx{value});
        });
      } else {
        Fault(item.first, fmt::format("unknown key \"{}\"; known are object, at_frames", key));
      }
    }
    if (!split.object.valid()) return Fault(node, "names no object");
    if (split.at_frames.empty()) Fault(node, "names no frame to split at");
    Once(split_, split.object, node, "split");
    overrides.split.push_back(std::move(split));
  }

  void ReadTexts(const YAML::Node& node,
                 std::vector<TextOverride>& texts,
                 std::vector<NamedObject>& named) {
    if (node.IsNull()) return;
    if (!node.IsMap()) return Fault(node, "must be a map of objects");
    std::set<int> seen;
    for (const auto& item : node) {
      const std::string text =
          item.second.IsScalar() ? item.second.as<std::string>("") : std::string();
      if (text.empty()) Fault(item.second, "must be a name");
      texts.push_back({ReadObject(item.first, named), text, Line(item.first)});
      Once(seen, texts.back().object, item.first, "one map");
    }
  }

  void ReadGround(const YAML::Node& node) {
    if (!node.IsMap()) return Fault(node, "must be a map {up_camera: [x, y, z], height_m: ...}");
    GroundHint hint;
    hint.height_m = NAN;
    for (const auto& item : node) {
      const std::string key = item.first.as<std::string>("");
      if (key == "height_m") {
        hint.height_m = item.second.as<double>(NAN);
      } else if (key == "up_camera") {
        Eigen::Vector3d up = Eigen::Vector3d::Constant(NAN);
        if (item.second.IsSequence() && item.second.size() == 3) {
          for (int n = 0; n < 3; ++n) up[n] = item.second[n].as<double>(NAN);
        }
        if (!up.allFinite() || up.norm() < 1e-6)
          Fault(item.second, "must be a direction [x, y, z]");
        hint.up_camera = up.normalized();
      } else {
        Fault(item.first, fmt::format("unknown key \"{}\"; known are up_camera, height_m", key));
      }
    }
    if (!(hint.height_m > 0 && hint.height_m <= kMaxHeightM)) {
      Fault(node, fmt::format("height_m must lie in (0, {}]", kMaxHeightM));
    }
    overrides.ground = hint;
  }

  void Fault(const YAML::Node& node, std::string_view what) {
    if (++num_faults_ > kMaxFaults) return;
    faults +=
        fmt::format("{}{}:{}: {}", faults.empty() ? "" : "\n", overrides.file, Line(node), what);
  }

  int num_items_ = 0;
  int num_faults_ = 0;
  std::set<int> dropped_;
  std::set<int> merged_;
  std::set<int> split_;
};

std::string TextsText(std::string_view what, std::vector<TextOverride> texts) {
  std::map<int, std::string> sorted;
  for (const TextOverride& text : texts) sorted[text.object.value] = text.text;
  std::string result;
  for (const auto& [object, text] : sorted) result += fmt::format("{} {} {}\n", what, object, text);
  return result;
}

std::string NamesText(const std::vector<NamedObject>& names) {
  std::set<std::string> lines;
  for (const NamedObject& name : names)
    lines.insert(fmt::format("named {} {}\n", name.object.value, name.class_name));
  return fmt::format("{}", fmt::join(lines, ""));
}

}  // namespace

Result<Overrides> DecodeOverrides(std::string_view text, std::string_view name) {
  if (text.size() > kMaxBytes) {
    return InvalidConfig(fmt::format(
        "{}: {} bytes are too many for overrides; at most {}", name, text.size(), kMaxBytes));
  }
  try {
    OverridesReader reader(name);
    reader.Read(YAML::Load(std::string(text)));
    if (!reader.faults.empty()) return InvalidConfig(reader.faults);
    return std::move(reader.overrides);
  } catch (const YAML::Exception& e) {
    return InvalidConfig(fmt::format("{}:{}: {}", name, e.mark.line + 1, e.msg));
  }
}

std::string TrackOverridesText(const Overrides& overrides) {
  std::set<int> drop;
  for (const ObjectOverride& object : overrides.drop) drop.insert(object.object.value);
  std::string text;
  for (const int object : drop) text += fmt::format("drop {}\n", object);
  for (const MergeOverride& merge : overrides.merge) {
    text += fmt::format("merge {}", merge.kept.value);
    for (const ObjectId object : merge.merged) text += fmt::format(" {}", object.value);
    text += '\n';
  }
  for (const SplitOverride& split : overrides.split) {
    text += fmt::format("split {}", split.object.value);
    for (const FrameIdx frame : split.at_frames) text += fmt::format(" {}", frame.value);
    text += '\n';
  }
  return text + TextsText("relabel", overrides.relabel) + NamesText(NamesOfTracks(overrides));
}

std::string ChoiceOverridesText(const Overrides& overrides) {
  return TextsText("choose", overrides.choose) + NamesText(NamesOfChoices(overrides));
}

std::string GroundOverridesText(const Overrides& overrides) {
  if (!overrides.ground) return {};
  const Eigen::Vector3d& up = overrides.ground->up_camera;
  return fmt::format("ground {} {} {} {}\n", up.x(), up.y(), up.z(), overrides.ground->height_m);
}

Result<std::string> EncodeApplied(const std::vector<std::string>& applied, std::string_view name) {
  return EncodeDocument(kAppliedFormat, applied, name, DescribeApplied);
}

Result<std::vector<std::string>> DecodeApplied(TextSource text, std::string_view name) {
  return DecodeDocument<std::vector<std::string>>(
      kAppliedFormat, std::move(text), name, DescribeApplied);
}

}  // namespace deepslam::artifact
