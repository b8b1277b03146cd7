// The scenes that come with the project.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>

#include "deepslam/synth/camera_path.h"
#include "deepslam/synth/scene_description.h"

namespace deepslam::synth {
namespace {

namespace fs = std::filesystem;

std::string ReadText(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<fs::path> SceneFiles() {
  std::vector<fs::path> files;
  const fs::path folder = fs::path(DEEPSLAM_SOURCE_DIR) / "configs/scenes";
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  return files;
}

void ExpectUsable(const SceneDescription& scene, const std::string& what) {
  EXPECT_FALSE(scene.objects.empty()) << what;
  for (const Pose3& pose : CameraPath(scene)) {
    const Eigen::Vector3d p = pose.translation_m;
    ASSERT_TRUE(p.allFinite()) << what;
    ASSERT_LT(std::abs(p.x()), scene.room_size_m.x() / 2 - 0.1) << what;
    ASSERT_LT(std::abs(p.y()), scene.room_size_m.y() / 2 - 0.1) << what;
    // Steeper than this the camera looks at the floor alone.
    ASSERT_GT((pose.rotation * Eigen::Vector3d::UnitZ()).z(), -0.75) << what;
  }
}

TEST(SceneFiles, AreUsableAndTheirProductsWithheld) {
  const std::string withheld =
      ReadText(fs::path(DEEPSLAM_SOURCE_DIR) / "configs/withheld_models.yaml");
  ASSERT_GE(SceneFiles().size(), 7u);
  for (const fs::path& file : SceneFiles()) {
    const Result<SceneDescription> scene = ParseScene(ReadText(file), file);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ExpectUsable(*scene, file.filename().string());
    for (const SceneObject& object : scene->objects)
      EXPECT_THAT(withheld, testing::HasSubstr("id: \"" + object.model + "\"")) << file;
  }
}

TEST(SceneFiles, LadderHasItsRungs) {
  const fs::path file = fs::path(DEEPSLAM_SOURCE_DIR) / "configs/scenes/ladder.yaml";
  for (const char* rung : {"clean",
                           "sensor",
                           "noise_x2",
                           "noise_x4",
                           "missing_30",
                           "missing_60",
                           "few_views",
                           "table_edges"}) {
    const Result<SceneDescription> scene = ParseScene(ReadText(file), file, rung);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    ExpectUsable(*scene, rung);
  }
}

}  // namespace
}  // namespace deepslam::synth
