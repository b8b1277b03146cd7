#include "deepslam/artifact/class_table_yaml.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "deepslam/core/yaml_quotes.h"

namespace deepslam::artifact {
namespace {

constexpr int kVersion = 1;
constexpr double kMaxSizeM = 20;
// Aliases can make a small file huge.
constexpr std::size_t kMaxBytes = 1U << 20;
constexpr std::size_t kMaxClasses = 1000;
constexpr std::size_t kMaxLabels = 10'000;
constexpr int kMaxFaults = 50;
constexpr std::string_view kHeader =
    "# Classes of objects the map may hold. `labels` are what detectors call them, `library` the "
    "classes of CAD models\n"
    "# that may stand for them, `size_m` the range of the longest side and `height_m` of the "
    "height of real ones.\n"
    "# A class without labels is found by its depth alone; `furniture` takes what fits no other.\n";

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
        Fault(item.first, fmt::format("unknown key \"{}\"", key));
    }
    const YAML::Node version = root["version"];
    if (!version || version.as<int>(-1) != kVersion) {
      Fault(version ? version : root, fmt::format("version must be {}", kVersion));
    }
    if (root["classes"].size() > kMaxClasses)
      return Fault(root["classes"], fmt::format("more than {} classes", kMaxClasses));
    for (const YAML::Node& node : root["classes"]) ReadClass(node);
    if (table.classes.empty()) Fault(root, "holds no class");
  }

  ClassTable table;
  std::string faults;

 private:
  void ReadClass(const YAML::Node& node) {
    if (!node.IsMap()) return Fault(node, "a class must be a map");
    ObjectClass c;
    for (const auto& item : node) {
      const std::string key = item.first.as<std::string>("");
      if (key == "name") {
        c.name = item.second.as<std::string>("");
      } else if (key == "labels") {
        c.detector_labels = Strings(item.second);
      } else if (key == "library") {
        c.library_classes = Strings(item.second);
      } else if (key == "size_m") {
        ReadRange(item.second, c.min_size_m, c.max_size_m);
      } else if (key == "height_m") {
        ReadRange(item.second, c.min_height_m, c.max_height_m);
      } else if (key == "colour") {
        ReadColour(item.second, c);
      } else {
        Fault(item.first,
              fmt::format(
                  "unknown key \"{}\"; known are name, labels, library, size_m, height_m, colour",
                  key));
      }
    }
    if (!IsClassName(c.name))
      Fault(node, fmt::format("name \"{}\" must be lower-case letters, digits and _", c.name));
    if (!names_.insert(c.name).second)
      Fault(node, fmt::format("class \"{}\" stands twice", c.name));
    for (const std::string& label : c.detector_labels) {
      if (!labels_.insert(label).second)
        Fault(node, fmt::format("label \"{}\" belongs to two classes", label));
    }
    table.classes.push_back(std::move(c));
  }

  std::vector<std::string> Strings(const YAML::Node& node) {
    std::vector<std::string> strings;
    if (!node.IsSequence()) {
      Fault(node, "must be a list");
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

  void ReadColour(const YAML::Node& node, ObjectClass& c) {
    if (!node.IsSequence() || node.size() != 3)
      return Fault(node, "colour must be [red, green, blue]");
    for (std::size_t i = 0; i < 3; ++i) {
      c.colour_rgb[i] = node[i].as<int>(-1);
      if (c.colour_rgb[i] < 0 || c.colour_rgb[i] > 255)
        return Fault(node, "colours must lie in [0, 255]");
    }
  }

  void Fault(const YAML::Node& node, std::string_view what) {
    if (++num_faults_ > kMaxFaults) return;
    faults +=
        fmt::format("{}{}:{}: {}", faults.empty() ? "" : "\n", name_, node.Mark().line + 1, what);
  }

  std::string name_;
  std::size_t num_labels_ = 0;
  int num_faults_ = 0;
  std::set<std::string> names_;
  std::set<std::string> labels_;
};

}  // namespace

ClassTable DefaultClassTable() {
  // Sizes span what furniture shops sell, with a tenth to spare for measuring.
  return {{{"chair", {"chair"}, {"chair"}, 0.45, 1.5, 0.4, 1.4, {230, 126, 34}},
           {"table",
            {"dining table", "table", "desk"},
            {"table", "desk"},
            0.4,
            4.0,
            0.3,
            1.2,
            {52, 152, 219}},
           {"sofa", {"couch", "sofa"}, {"sofa"}, 0.7, 3.6, 0.5, 1.3, {155, 89, 182}},
           {"bed", {"bed"}, {"bed"}, 1.2, 2.7, 0.25, 2.0, {231, 76, 60}},
           {"cabinet", {}, {"cabinet"}, 0.3, 2.6, 0.3, 2.5, {39, 174, 96}},
           {"shelf", {}, {"shelf"}, 0.5, 3.0, 0.5, 2.7, {26, 188, 156}},
           {"furniture",
            {},
            {"cabinet", "table", "shelf", "desk"},
            0.2,
            3.5,
            0.15,
            2.7,
            {149, 165, 166}}}};
}

std::string EncodeClassTable(const ClassTable& table) {
  std::string text = fmt::format("{}version: {}\nclasses:\n", kHeader, kVersion);
  for (const ObjectClass& c : table.classes) {
    text += fmt::format("  - name: {}\n    labels: [{}]\n    library: [{}]\n",
                        c.name,
                        Quoted(c.detector_labels),
                        Quoted(c.library_classes));
    text += fmt::format("    size_m: [{}, {}]\n    height_m: [{}, {}]\n    colour: [{}]\n",
                        c.min_size_m,
                        c.max_size_m,
                        c.min_height_m,
                        c.max_height_m,
                        fmt::join(c.colour_rgb, ", "));
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

}  // namespace deepslam::artifact
