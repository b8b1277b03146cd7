#include "deepslam/synth/scene_description.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

namespace deepslam::synth {
namespace {

constexpr int kMaxFrames = 100'000;
constexpr int kMaxSidePx = 4096;

// One table of the file. Remembers the first fault and the names that were asked for.
class Table {
 public:
  Table(YAML::Node node,
        const std::filesystem::path& file,
        std::string path,
        std::optional<Error>& fault)
      : node_(std::move(node)), file_(file), path_(std::move(path)), fault_(fault) {
    if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap())
      Fail(node_, path_, "is not a table");
  }

  void Number(const std::string& name, double& value, double min, double max) {
    const YAML::Node node = Find(name);
    if (!node) return;
    double read = 0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, read) ||
        !(read >= min && read <= max)) {
      Fail(node,
           Path(name),
           fmt::format("is '{}', expected a number of {} .. {}", Shown(node), min, max));
      return;
    }
    value = read;
  }

  void Number(const std::string& name, int& value, int min, int max) {
    double read = value;
    Number(name, read, min, max);
    if (read != std::floor(read)) {
      Fail(Find(name), Path(name), fmt::format("is '{}', expected a whole number", read));
      return;
    }
    value = static_cast<int>(read);
  }

  void Switch(const std::string& name, bool& value) {
    const YAML::Node node = Find(name);
    if (!node) return;
    if (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)) {
      Fail(node, Path(name), fmt::format("is '{}', expected true or false", Shown(node)));
    }
  }

  void Text(const std::string& name, std::string& value, bool required) {
    const YAML::Node node = Find(name);
    if (!node) {
      if (required) Fail(node_, Path(name), "is missing");
      return;
    }
    if (!node.IsScalar() || node.Scalar().empty()) {
      Fail(node, Path(name), "is not a word");
      return;
    }
    value = node.Scalar();
  }

  template <typename Vector>
  void Vec(const std::string& name, Vector& value, double min, double max, bool required = false) {
    const YAML::Node node = Find(name);
    if (!node) {
      if (required) Fail(node_, Path(name), "is missing");
      return;
    }
    const auto count = static_cast<std::size_t>(value.size());
    if (!node.IsSequence() || node.size() != count) {
      Fail(node, Path(name), fmt::format("is not a list of {} numbers", count));
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      double read = 0;
      if (!node[i].IsScalar() || !YAML::convert<double>::decode(node[i], read) ||
          !(read >= min && read <= max)) {
        Fail(node[i],
             fmt::format("{}[{}]", Path(name), i),
             fmt::format("is '{}', expected a number of {} .. {}", Shown(node[i]), min, max));
        return;
      }
      value[static_cast<Eigen::Index>(i)] = read;
    }
  }

  Table Sub(const std::string& name) { return Table(Find(name), file_, Path(name), fault_); }

  std::vector<Table> List(const std::string& name) {
    const YAML::Node node = Find(name);
    std::vector<Table> tables;
    if (!node) return tables;
    if (!node.IsSequence()) {
      Fail(node, Path(name), "is not a list");
      return tables;
    }
    for (std::size_t i = 0; i < node.size(); ++i) {
      tables.emplace_back(node[i], file_, fmt::format("{}[{}]", Path(name), i), fault_);
    }
    return tables;
  }

  // To be called last: what was not asked for is unknown.
  void RefuseOthers() {
    if (!node_.IsMap()) return;
    for (const auto& entry : node_) {
      const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (asked_.contains(name)) continue;
      Fail(entry.first,
           Path(name),
           fmt::format("is unknown; known here: {}", fmt::join(asked_, ", ")));
    }
  }

  [[nodiscard]] int line() const { return node_.Mark().is_null() ? 0 : node_.Mark().line + 1; }

  void Fail(const YAML::Node& node, const std::string& field, const std::string& what) {
    if (fault_) return;
    const bool has_line = node.IsDefined() && !node.Mark().is_null();
    const std::string place =
        has_line ? fmt::format("{}:{}", file_.string(), node.Mark().line + 1) : file_.string();
    fault_ = InvalidConfig(fmt::format("{}: field '{}' {}", place, field, what));
  }
  [[nodiscard]] std::string Path(const std::string& name) const {
    return path_.empty() ? name : path_ + "." + name;
  }

 private:
  YAML::Node Find(const std::string& name) {
    asked_.insert(name);
    if (!node_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    // A lookup that fails gives a node that throws at every question.
    const YAML::Node found = std::as_const(node_)[name];
    return found.IsDefined() ? found : YAML::Node(YAML::NodeType::Undefined);
  }
  static std::string Shown(const YAML::Node& node) {
    return node.IsScalar() ? node.Scalar().substr(0, 60) : "a structure";
  }

  YAML::Node node_;
  std::filesystem::path file_;
  std::string path_;
  std::optional<Error>& fault_;
  std::set<std::string> asked_;
};

void ReadCamera(Table camera, PinholeCamera& value) {
  value = {640, 480, 525.0, 525.0, 319.5, 239.5};
  camera.Number("width", value.width, 16, kMaxSidePx);
  camera.Number("height", value.height, 16, kMaxSidePx);
  camera.Number("fx", value.fx, 0.05 * value.width, 50.0 * value.width);
  camera.Number("fy", value.fy, 0.05 * value.height, 50.0 * value.height);
  camera.Number("cx", value.cx, 0, value.width - 1);
  camera.Number("cy", value.cy, 0, value.height - 1);
  camera.RefuseOthers();
}

void ReadRoom(Table room, SceneDescription& scene) {
  room.Vec("size_m", scene.room_size_m, 1, 100);
  room.Text("floor", scene.floor, false);
  if (scene.floor != "wood" && scene.floor != "carpet" && scene.floor != "tiles") {
    room.Fail(YAML::Node(YAML::NodeType::Undefined),
              room.Path("floor"),
              fmt::format("is '{}', expected wood, carpet or tiles", scene.floor));
  }
  Eigen::Vector3d wall(scene.wall_colour.r, scene.wall_colour.g, scene.wall_colour.b);
  room.Vec("wall_colour_rgb", wall, 0, 255);
  scene.wall_colour = {static_cast<std::uint8_t>(wall.x()),
                       static_cast<std::uint8_t>(wall.y()),
                       static_cast<std::uint8_t>(wall.z())};
  room.Number("posters", scene.num_posters, 0, 40);
  room.Number("ambient", scene.ambient, 0, 1);
  room.RefuseOthers();
}

void ReadOrbit(Table orbit, SceneOrbit& value) {
  orbit.Vec("centre_m", value.centre_m, -100, 100);
  orbit.Number("radius_m", value.radius_m, 0.1, 100);
  orbit.Number("height_m", value.height_m, 0.1, 100);
  orbit.Number("target_height_m", value.target_height_m, 0, 100);
  orbit.Number("start_deg", value.start_deg, -3600, 3600);
  orbit.Number("sweep_deg", value.sweep_deg, -3600, 3600);
  orbit.Number("shake_m", value.shake_m, 0, 1);
  orbit.Number("shake_deg", value.shake_deg, 0, 30);
  orbit.RefuseOthers();
}

void ReadLists(Table& root, SceneDescription& scene) {
  for (Table light : root.List("lights")) {
    SceneLight value;
    light.Vec("position_m", value.position_m, -100, 100, true);
    light.Number("side_m", value.side_m, 0.01, 10);
    light.Number("power", value.power, 0, 1000);
    light.RefuseOthers();
    scene.lights.push_back(value);
  }
  for (Table object : root.List("objects")) {
    SceneObject value;
    object.Text("class", value.class_name, true);
    object.Text("model", value.model, true);
    object.Vec("position_m", value.position_m, -100, 100, true);
    object.Number("yaw_deg", value.yaw_deg, -3600, 3600);
    object.RefuseOthers();
    value.line = object.line();
    scene.objects.push_back(value);
  }
}

SceneDescription ReadScene(Table root) {
  SceneDescription scene;
  int seed = 1;
  root.Number("seed", seed, 0, 2'000'000'000);
  scene.seed = static_cast<std::uint64_t>(seed);
  root.Number("frames", scene.num_frames, 1, kMaxFrames);
  root.Number("frames_per_s", scene.frames_per_s, 0.1, 1000);
  root.Number("depth_units_per_m", scene.depth_units_per_m, 1, 10'000);
  ReadCamera(root.Sub("camera"), scene.camera);
  ReadRoom(root.Sub("room"), scene);
  ReadOrbit(root.Sub("orbit"), scene.orbit);
  ReadLists(root, scene);
  Table faults = root.Sub("faults");
  faults.Switch("depth_noise", scene.faults.depth_noise);
  faults.Switch("depth_holes", scene.faults.depth_holes);
  faults.Switch("colour_noise", scene.faults.colour_noise);
  faults.RefuseOthers();
  root.RefuseOthers();
  return scene;
}

}  // namespace

Result<SceneDescription> ParseScene(const std::string& text, const std::filesystem::path& file) {
  try {
    std::optional<Error> fault;
    const YAML::Node root = YAML::Load(text);
    if (!root.IsMap())
      return InvalidConfig(
          fmt::format("{}: holds no scene; see configs/scenes/demo_room.yaml", file.string()));
    SceneDescription scene = ReadScene(Table(root, file, "", fault));
    if (fault) return *fault;
    return scene;
  } catch (const YAML::Exception& fault) {
    return InvalidConfig(fmt::format("{}:{}: not valid YAML ({})",
                                     file.string(),
                                     fault.mark.is_null() ? 1 : fault.mark.line + 1,
                                     fault.msg));
  }
}

}  // namespace deepslam::synth
