// Writes the report page of a made-up map: boxes on a floor, the third with a name that wants to be
// markup, the fourth without a surface. `deepslam_web_page FILE [NUM_OBJECTS]` writes the page;
// nothing else is read or written.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "deepslam/gltf/scene_writer.h"
#include "deepslam/report/draw.h"
#include "deepslam/report/report.h"
#include "support/box_meshes.h"

namespace deepslam {
namespace {

using testing_support::BoxMesh;

struct Item {
  std::string name;
  std::string class_name;
  Eigen::Vector3d size_m;
  Eigen::Vector3d place_m;
  Rgb8 colour;
  bool has_surface = true;
};

const Item kItems[] = {
    {"chair_00", "chair", {0.5, 0.5, 0.9}, {1.0, -0.9, 0.45}, {230, 120, 30}},
    {"table_01", "table", {0.8, 1.4, 0.7}, {1.2, 0.6, 0.35}, {40, 120, 200}},
    {"<b>odd & 'name'</b> \xE6\xA4\x85\xF0\x9F\xAA\x91",
     "box",
     {0.3, 0.3, 0.3},
     {0.2, 0.0, 0.15},
     {40, 160, 90}},
    {"ghost_03", "ghost", {0, 0, 0}, {0.4, 1.0, 0.2}, {90, 90, 90}, false},
};

// The items above, then a hall of chairs in rows.
std::vector<Item> MakeItems(int count) {
  std::vector<Item> items(std::begin(kItems), std::end(kItems));
  items.resize(static_cast<std::size_t>(std::min(count, static_cast<int>(items.size()))));
  const int per_row = std::max(1, static_cast<int>(std::sqrt(count)));
  for (int n = static_cast<int>(items.size()); n < count; ++n) {
    Item item = kItems[0];
    item.name = "chair_" + std::to_string(n);
    item.place_m += Eigen::Vector3d(3.0 + n / per_row, n % per_row, 0);
    items.push_back(item);
  }
  return items;
}

// A room around the items above.
Layout MakeLayout() {
  Layout layout;
  LayoutRoom room;
  room.polygon_m = {{-1, -2}, {2.5, -2}, {2.5, 2}, {-1, 2}};
  room.guessed.assign(4, false);
  for (std::size_t n = 0; n < 4; ++n) {
    LayoutWall wall;
    wall.from_m = room.polygon_m[n];
    wall.to_m = room.polygon_m[(n + 1) % 4];
    wall.top_m = 2;
    wall.rooms = {0};
    wall.confidence = 0.9;
    layout.walls.push_back(wall);
  }
  layout.rooms = {room};
  return layout;
}

// Boxes behind the walls' faces.
std::vector<gltf::GltfPart> MakeParts() {
  std::vector<gltf::GltfPart> parts;
  for (const LayoutWall& wall : MakeLayout().walls) {
    constexpr float kThickness_m = 0.06F;
    gltf::GltfPart part;
    part.id = static_cast<int>(parts.size());
    part.name = "wall_0" + std::to_string(part.id);
    part.kind = "wall";
    part.rooms = {0};
    part.figures = {{"length_m", wall.length_m()}, {"height_m", 2.0}};
    const Eigen::Vector2d along = (wall.to_m - wall.from_m).normalized();
    const Eigen::Vector2d outward(along.y(), -along.x());
    const Eigen::Vector2d middle =
        0.5 * (wall.from_m + wall.to_m) + 0.5 * static_cast<double>(kThickness_m) * outward;
    const Eigen::Vector2f size = (wall.length_m() * along.cwiseAbs()).cast<float>() +
                                 kThickness_m * outward.cwiseAbs().cast<float>();
    part.mesh_world = BoxMesh({size.x(), size.y(), 2.0F});
    for (Eigen::Vector3f& p : part.mesh_world.vertices)
      p += Eigen::Vector3d(middle.x(), middle.y(), 1).cast<float>();
    parts.push_back(std::move(part));
  }
  return parts;
}

gltf::GltfScene MakeScene(const std::vector<Item>& items) {
  gltf::GltfScene scene;
  scene.parts = MakeParts();
  for (const Item& item : items) {
    gltf::GltfObject object;
    object.name = item.name;
    object.class_name = item.class_name;
    if (item.has_surface) object.mesh = BoxMesh(item.size_m.cast<float>());
    object.world_from_object.translation_m = item.place_m;
    object.class_colour = item.colour;
    scene.objects.push_back(std::move(object));
  }
  TriangleMesh measured = BoxMesh({0.6f, 0.4f, 0.5f});  // what no object stands for
  for (Eigen::Vector3f& vertex : measured.vertices) {
    vertex += Eigen::Vector3f(2.1f, -1.6f, 0.25f);
    measured.colours.push_back({180, 170, 160});
  }
  scene.room = measured;
  TriangleMesh floor;
  floor.vertices = {{-1, -2, 0}, {2.5f, -2, 0}, {2.5f, 2, 0}, {-1, 2, 0}};
  floor.faces = {{0, 1, 2}, {0, 2, 3}};
  scene.ground = floor;
  return scene;
}

report::Picture Plain(Rgb8 colour) {
  const Result<std::string> jpeg = report::EncodeJpeg(ColourImage(64, 64, colour));
  return {jpeg.ok() ? *jpeg : std::string(), "image/jpeg", "made up"};
}

report::ObjectRow MakeRow(const Item& item) {
  report::ObjectRow row;
  row.name = item.name;
  row.class_name = item.class_name;
  row.size_m = item.size_m;
  row.world_from_object.translation_m = item.place_m;
  row.confidence = 0.8;
  row.num_views = 7;
  row.source = "CAD library";
  row.credit = "Model by Ana";
  row.colour = item.colour;
  report::CandidateRow winner{"better_shape", "CAD library", 0.8, 0.9, 0.7, 0.01, 7, true, "", {}};
  winner.thumbnail = Plain(item.colour);
  row.candidates = {winner,
                    {"worse_shape", "own measurement", 0.6, 0.7, 0.6, 0.05, 7, false, "", {}}};
  for (int i = 0; i < 200 && item.has_surface; ++i) {
    const Eigen::Vector3d offset(0.5 * item.size_m.x(), 0.001 * i, 0.002 * i);
    row.measured_world.push_back((item.place_m - offset).cast<float>());
  }
  row.pictures = {Plain({120, 120, 120})};
  return row;
}

report::ReportContent MakeContent(const std::vector<Item>& items) {
  report::ReportContent content;
  content.title = "made-up room";
  content.verdict = "doubtful";
  content.verdict_reasons = {"this is a test"};
  for (int i = 0; i < 40; ++i) {
    TrackedFrame frame;
    frame.frame = FrameIdx{i};
    frame.world_from_camera.translation_m = {-0.8 + 0.01 * i, -1.0 + 0.05 * i, 1.4};
    content.map.frames.push_back(frame);
    content.tracked_world_from_camera.push_back(frame.world_from_camera);
    content.tracked_world_from_camera.back().translation_m.z() += 0.001 * i;
  }
  content.map.keyframes = {FrameIdx{0}, FrameIdx{20}};
  content.map.has_ground = true;
  content.layout_world = MakeLayout();
  content.heights = {{FrameIdx{0}, 1.4, 1.4, 1.4}, {FrameIdx{20}, 1.4, 1.42, 1.4}};
  for (const Item& item : items) content.objects.push_back(MakeRow(item));
  return content;
}

int Run(const char* file, int num_objects) {
  const std::vector<Item> items = MakeItems(num_objects);
  report::ReportContent content = MakeContent(items);
  const Result<std::string> glb = gltf::WriteGlb(MakeScene(items), gltf::GltfOptions{});
  if (!glb.ok()) {
    std::fprintf(stderr, "%s\n", glb.error().message.c_str());
    return 1;
  }
  content.scene_glb = *glb;
  std::ofstream out(file, std::ios::binary);
  out << report::RenderReport(content);
  return out.good() ? 0 : 1;
}

}  // namespace
}  // namespace deepslam

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::fprintf(stderr, "usage: deepslam_web_page FILE [NUM_OBJECTS]\n");
    return 2;
  }
  return deepslam::Run(
      argv[1], argc == 3 ? std::atoi(argv[2]) : static_cast<int>(std::size(deepslam::kItems)));
}
