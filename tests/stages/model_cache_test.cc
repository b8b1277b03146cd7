// Networks are loaded once, and again when their file changed.
#include <memory>
#include <set>
#include <string>

#include <gmock/gmock.h>

#include "deepslam/core/sha256.h"
#include "deepslam/stages/content_hashes.h"
#include "deepslam/stages/model_cache.h"
#include "support/temp_dir.h"
#include "support/tiny_onnx.h"

namespace deepslam::stages {
namespace {

using testing::HasSubstr;
using testing_support::TempDir;
using testing_support::TinyNetwork;
using testing_support::WriteOnnx;
using testing_support::WriteText;
namespace fs = std::filesystem;

// A YOLOv8 head of one class and one box with that score.
std::string OneBox(float score) {
  TinyNetwork network;
  const std::vector<float> column = {32, 32, 16, 16, score};
  std::vector<float> values(column.size() * 84, 0);
  for (std::size_t row = 0; row < column.size(); ++row) values[row * 84] = column[row];
  network.outputs = {{{1, 5, 84}, values}};
  network.metadata = {{"names", "{0: 'chair'}"}};
  return WriteOnnx(network);
}

double BestScore(const detect::Detector& detector) {
  const auto found = detector.Detect(ColourImage(64, 64));
  EXPECT_TRUE(found.ok()) << found.error().message;
  return found.ok() && !found->empty() ? found->front().score : 0;
}

TEST(ModelCache, LoadsANetworkOnce) {
  const TempDir dir;
  const fs::path file = dir.path() / "net.onnx";
  WriteText(file, OneBox(0.75F));
  ModelCache cache;
  const auto first = cache.Detector(file, {});
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_NEAR(BestScore(**first), 0.75, 1e-6);
  EXPECT_EQ(cache.Detector(file, {})->get(), first->get());
}

TEST(ModelCache, ANewFileIsANewNetwork) {
  const TempDir dir;
  const fs::path file = dir.path() / "net.onnx";
  WriteText(file, OneBox(0.75F));
  ModelCache cache;
  const auto first = cache.Detector(file, {});
  ASSERT_TRUE(first.ok()) << first.error().message;
  WriteText(dir.path() / "other.onnx", OneBox(0.5F));
  fs::rename(dir.path() / "other.onnx", file);
  const auto second = cache.Detector(file, {});
  ASSERT_TRUE(second.ok()) << second.error().message;
  EXPECT_NEAR(BestScore(**second), 0.5, 1e-6);
  EXPECT_NEAR(BestScore(**first), 0.75, 1e-6) << "whoever holds the old one keeps it";
}

TEST(ModelCache, OtherOptionsAreAnotherDetector) {
  const TempDir dir;
  const fs::path file = dir.path() / "net.onnx";
  WriteText(file, OneBox(0.75F));
  ModelCache cache;
  detect::DetectorOptions strict;
  strict.min_score = 0.9;
  ASSERT_TRUE(cache.Detector(file, {}).ok());
  EXPECT_EQ(BestScore(**cache.Detector(file, strict)), 0);
}

TEST(ContentHashes, FollowTheFile) {
  const TempDir dir;
  const fs::path file = dir.path() / "a.txt";
  WriteText(file, "one");
  ContentHashes hashes;
  EXPECT_EQ(*hashes.Of(file), Sha256Hex("one"));
  EXPECT_EQ(*hashes.Of(file), Sha256Hex("one"));
  WriteText(file, "three");
  EXPECT_EQ(*hashes.Of(file), Sha256Hex("three"));
  const std::string folder = *hashes.Of(dir.path());
  WriteText(dir.path() / "deep" / "b.txt", "x");
  EXPECT_NE(*hashes.Of(dir.path()), folder);
  fs::remove(file);
  EXPECT_FALSE(hashes.Of(file).ok());
}

TEST(ModelCache, FaultsNameTheFile) {
  const TempDir dir;
  WriteText(dir.path() / "net.onnx", "no network");
  ModelCache cache;
  EXPECT_THAT(cache.Detector(dir.path() / "net.onnx", {}).error().message, HasSubstr("net.onnx"));
  EXPECT_FALSE(cache.Detector(dir.path() / "none.onnx", {}).ok());
  EXPECT_FALSE(cache.Library(dir.path() / "none").ok());
}

// Networks that are none: whoever opens them says so, so that what is opened can be told.
TEST(FindShapePriors, OpensOnlyTheClassesAskedFor) {
  const TempDir dir;
  for (const std::string name : {"chair", "bed"}) {
    fs::create_directories(dir.path() / "priors" / name);
    for (const std::string file : {"sketch.onnx", "encoder.onnx", "decoder.onnx"})
      WriteText(dir.path() / "priors" / name / file, "no network");
  }
  ClassTable classes;
  for (const std::string name : {"bed", "chair", "table"})
    classes.classes.emplace_back().name = name;
  for (const auto& cache : {std::shared_ptr<ModelCache>(), std::make_shared<ModelCache>()}) {
    const ModelFolders folders = {dir.path(), cache};
    const std::string named = (dir.path() / "priors").string();
    const auto of_tables = FindShapePriors(folders, named, classes, std::set<std::string>{"table"});
    ASSERT_TRUE(of_tables.ok()) << of_tables.error().message;
    EXPECT_TRUE((*of_tables)->empty());
    const auto of_beds = FindShapePriors(folders, named, classes, std::set<std::string>{"bed"});
    ASSERT_FALSE(of_beds.ok());
    EXPECT_THAT(of_beds.error().message, HasSubstr("bed/sketch.onnx"));
    EXPECT_FALSE(FindShapePriors(folders, named, classes).ok());
  }
}

TEST(FindShapePriors, AFolderWithoutNetworksIsRefusedWhateverIsAskedFor) {
  const TempDir dir;
  fs::create_directories(dir.path() / "priors" / "spoon");
  ClassTable classes;
  classes.classes.emplace_back().name = "chair";
  const auto found = FindShapePriors(
      {dir.path(), {}}, (dir.path() / "priors").string(), classes, std::set<std::string>{"table"});
  ASSERT_FALSE(found.ok());
  EXPECT_THAT(found.error().message, HasSubstr("no networks of any class"));
}

}  // namespace
}  // namespace deepslam::stages
