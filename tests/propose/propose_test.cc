#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/core/parallel.h"
#include "deepslam/geometry/upright.h"
#include "deepslam/propose/level_cloud.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "staged_views.h"
#include "support/box_meshes.h"

namespace deepslam::propose {
namespace {

using testing_support::AddBox;
using testing_support::ChairMesh;
using testing_support::Stage;
using testing_support::StagedViews;
using testing_support::TableMesh;

LibraryModel Model(const std::string& name,
                   const std::string& class_name,
                   const TriangleMesh& mesh) {
  LibraryModel model;
  model.id = "test/" + name;
  model.name = name;
  model.class_name = class_name;
  model.creator = "somebody";
  model.licence = "public domain";
  Eigen::Vector3f low = mesh.vertices.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  model.size_m = (high - low).cast<double>();
  model.shape = *shape::Voxelize(mesh);
  return model;
}

TriangleMesh CubeChair() {
  TriangleMesh mesh;
  AddBox({-0.4F, -0.4F, 0}, {0.4F, 0.4F, 0.4F}, mesh);
  AddBox({-0.4F, -0.4F, 0.4F}, {-0.2F, 0.4F, 0.8F}, mesh);
  return mesh;
}

TriangleMesh PedestalTable() {
  TriangleMesh mesh;
  AddBox({-0.4F, -0.4F, 0.7F}, {0.4F, 0.4F, 0.74F}, mesh);
  AddBox({-0.05F, -0.05F, 0}, {0.05F, 0.05F, 0.7F}, mesh);
  AddBox({-0.2F, -0.2F, 0}, {0.2F, 0.2F, 0.04F}, mesh);
  return mesh;
}

std::shared_ptr<const ModelLibrary> TestLibrary() {
  auto library = std::make_shared<ModelLibrary>();
  library->models = {
      Model("armless", "chair", ChairMesh(0.42F, 0.45F, 0.45F, 0.9F, 0.04F)),
      Model("bar", "chair", ChairMesh(0.4F, 0.4F, 0.75F, 1.1F, 0.04F)),
      Model("cube", "chair", CubeChair()),
      Model("pedestal", "table", PedestalTable()),
      Model("plain", "table", TableMesh(1.4F, 0.8F, 0.74F, 0.06F)),
  };
  return library;
}

ClassTable Classes() {
  ClassTable table;
  for (const char* name : {"chair", "table"}) {
    ObjectClass entry;
    entry.name = name;
    entry.library_classes = {name};
    entry.min_size_m = 0.4;
    entry.max_size_m = 3.0;
    table.classes.push_back(entry);
  }
  ObjectClass furniture;
  furniture.name = "furniture";
  furniture.traits = {.solid_inside = true, .fallback = true};
  table.classes.push_back(furniture);
  return table;
}

const ModelLibrary& Library() {
  static const std::shared_ptr<const ModelLibrary> library = TestLibrary();
  return *library;
}

Proposals Retrieve(const std::string& class_name,
                   std::span<const ObjectView> views,
                   InputChannels channels = InputChannels::kColourAndDepth) {
  const std::unique_ptr<Proposer> proposer = MakeRetrievalProposer(
      std::shared_ptr<const ModelLibrary>(&Library(), [](const ModelLibrary*) {}),
      Classes(),
      {},
      channels);
  const Result<Proposals> proposals = proposer->Propose({ObjectId{3}, class_name, views});
  EXPECT_TRUE(proposals.ok());
  return *proposals;
}

class RetrievesItself : public testing::TestWithParam<int> {};

TEST_P(RetrievesItself, FirstAndInTheRightSize) {
  const LibraryModel& model = Library().models[static_cast<std::size_t>(GetParam())];
  Stage stage;
  stage.size_m = model.size_m.maxCoeff();
  stage.noise_m = 0.002;
  const Proposals proposals = Retrieve(model.class_name, StagedViews(model.shape, stage));
  ASSERT_FALSE(proposals.candidates.empty());
  const ShapeCandidate& best = proposals.candidates.front();
  EXPECT_EQ(best.library_id, model.id);
  EXPECT_NEAR(best.size_m, stage.size_m, 0.06 * stage.size_m);
  EXPECT_LT(best.min_size_m, stage.size_m);
  EXPECT_GT(best.max_size_m, stage.size_m);
  EXPECT_THAT(best.credit, testing::HasSubstr("somebody"));
  EXPECT_EQ(best.source, CandidateSource::kRetrieval);
  EXPECT_FALSE(best.id.valid());
}

TEST_P(RetrievesItself, ByItsOutlinesAlone) {
  const LibraryModel& model = Library().models[static_cast<std::size_t>(GetParam())];
  Stage stage;
  stage.size_m = model.size_m.maxCoeff();
  std::vector<ObjectView> views = StagedViews(model.shape, stage);
  const Proposals proposals = Retrieve(model.class_name, views, InputChannels::kColour);
  ASSERT_FALSE(proposals.candidates.empty());
  const ShapeCandidate& best = proposals.candidates.front();
  EXPECT_EQ(best.library_id, model.id);
  // A cell of the raster in which outlines are compared is about 1/30 of the object.
  EXPECT_NEAR(best.size_m, stage.size_m, 0.1 * stage.size_m);
  // No depth value has a part in it.
  for (ObjectView& view : views)
    view.depth_crop_m = DepthImage(view.camera.width, view.camera.height, 7.0F);
  const Proposals blind = Retrieve(model.class_name, views, InputChannels::kColour);
  ASSERT_EQ(blind.candidates.size(), proposals.candidates.size());
  for (std::size_t n = 0; n < blind.candidates.size(); ++n) {
    EXPECT_EQ(blind.candidates[n].model, proposals.candidates[n].model);
    EXPECT_EQ(blind.candidates[n].proposal_score, proposals.candidates[n].proposal_score);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryModel, RetrievesItself, testing::Range(0, 5));

TEST(Retrieval, FindsTheModelFromAQuarterOfTheWayRound) {
  const LibraryModel& chair = Library().models[0];
  Stage stage;
  stage.size_m = 0.9;
  stage.num_views = 3;
  stage.sweep_rad = 0.8;
  stage.first_azimuth_rad = 2.0;
  EXPECT_EQ(Retrieve("chair", StagedViews(chair.shape, stage)).candidates.front().library_id,
            chair.id);
}

TEST(Retrieval, StretchesATableToItsMeasuredSize) {
  const LibraryModel large = Model("large", "table", TableMesh(1.8F, 0.7F, 0.72F, 0.07F));
  Stage stage;
  stage.size_m = 1.8;
  stage.distance_m = 2.6;
  const Proposals proposals = Retrieve("table", StagedViews(large.shape, stage));
  ASSERT_FALSE(proposals.candidates.empty());
  const ShapeCandidate& best = proposals.candidates.front();
  EXPECT_EQ(best.library_id, "test/plain");
  EXPECT_NEAR(best.size_m, 1.8, 0.09);
  const VoxelGrid& found = proposals.models.at(best.model);
  const shape::ShapeModel shape(found);
  EXPECT_NEAR(shape.extent().x() / shape.extent().y(), 0.7 / 1.8, 0.05);
  EXPECT_NEAR(shape.extent().z() / shape.extent().y(), 0.72 / 1.8, 0.05);
}

TEST(Retrieval, EveryCandidateHasItsModelAndKeysArePlain) {
  Stage stage;
  const Proposals proposals = Retrieve("chair", StagedViews(Library().models[0].shape, stage));
  for (const ShapeCandidate& candidate : proposals.candidates) {
    EXPECT_TRUE(proposals.models.contains(candidate.model)) << candidate.model;
    EXPECT_EQ(candidate.model.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-"),
              std::string::npos);
    EXPECT_LE(candidate.min_size_m, candidate.size_m);
    EXPECT_GE(candidate.max_size_m, candidate.size_m);
  }
  EXPECT_EQ(proposals.models.size(), proposals.candidates.size());
}

TEST(Retrieval, UnknownFurnitureTriesEveryClassOfItsSize) {
  const LibraryModel& table = Library().models[4];
  Stage stage;
  stage.size_m = 1.4;
  stage.distance_m = 2.4;
  const Proposals proposals = Retrieve("furniture", StagedViews(table.shape, stage));
  ASSERT_FALSE(proposals.candidates.empty());
  EXPECT_EQ(proposals.candidates.front().library_id, table.id);
}

// What was given its class by its size has models of that size, or those nearest to it; what a
// detector named may be seen in part.
TEST(Retrieval, OffersModelsOfTheSizeOfWhatNobodyNamed) {
  ClassTable classes = Classes();
  classes.classes[0].library_classes = {"chair", "table"};
  RetrievalOptions options;
  options.max_models = 3;
  const auto proposer = MakeRetrievalProposer(
      std::shared_ptr<const ModelLibrary>(&Library(), [](const ModelLibrary*) {}),
      classes,
      options);
  Stage stage;
  stage.size_m = 0.9;
  const std::vector<ObjectView> views = StagedViews(Library().models[0].shape, stage);
  ObjectObservations object{ObjectId{3}, "chair", views};
  object.is_named = false;
  const Result<Proposals> proposals = proposer->Propose(object);
  ASSERT_TRUE(proposals.ok());
  ASSERT_FALSE(proposals->candidates.empty());
  for (const ShapeCandidate& candidate : proposals->candidates)
    EXPECT_NE(candidate.library_id, "plain") << "1.4 m long, three times what was seen";
  // Nothing in the library is as small: there are candidates all the same.
  stage.size_m = 0.2;
  stage.distance_m = 0.6;
  const std::vector<ObjectView> toy = StagedViews(Library().models[0].shape, stage);
  object.views = toy;
  const Result<Proposals> nearest = proposer->Propose(object);
  ASSERT_TRUE(nearest.ok());
  EXPECT_FALSE(nearest->candidates.empty());
}

TEST(Retrieval, OffersNothingForAClassWhoseShapeNoModelHas) {
  ClassTable classes = Classes();
  classes.classes[0].traits.fused_only = true;
  const auto proposer = MakeRetrievalProposer(
      std::shared_ptr<const ModelLibrary>(&Library(), [](const ModelLibrary*) {}), classes, {});
  const std::vector<ObjectView> views = StagedViews(Library().models[0].shape, Stage());
  const Result<Proposals> proposals = proposer->Propose({ObjectId{3}, "chair", views});
  ASSERT_TRUE(proposals.ok());
  EXPECT_THAT(proposals->candidates, testing::IsEmpty());
  EXPECT_THAT(proposals->notes, testing::SizeIs(1));
}

TEST(Retrieval, WorksWithoutAGround) {
  Stage stage;
  stage.has_ground = false;
  stage.size_m = 0.9;
  const Proposals proposals = Retrieve("chair", StagedViews(Library().models[0].shape, stage));
  EXPECT_FALSE(proposals.candidates.empty());
}

TEST(FindLevel, WithoutAGroundIsAsThePicturesAreSaidToStand) {
  ObjectView standing;
  standing.world_from_camera = testing_support::LookAt({2, 1, 1.4}, {0, 0, 0.4});
  const Eigen::Vector3d up_camera(0, -1, 0);
  for (const QuarterTurn upright :
       {QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise}) {
    ObjectView view = standing;
    view.upright = upright;
    const LevelFrame level = FindLevel(std::vector<ObjectView>{view});
    EXPECT_FALSE(level.has_ground);
    const Eigen::Vector3d up = level.level_from_world.rotation * view.world_from_camera.rotation *
                               Turned(up_camera, Inverse(upright));
    EXPECT_LT((up - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  }
}

TEST(Retrieval, OutlinesStandWithoutAGroundAndOfUnknownFurniture) {
  Stage stage;
  stage.has_ground = false;
  stage.size_m = 0.9;
  const Proposals proposals =
      Retrieve("chair", StagedViews(Library().models[0].shape, stage), InputChannels::kColour);
  ASSERT_FALSE(proposals.candidates.empty());
  EXPECT_EQ(proposals.candidates.front().library_id, Library().models[0].id);
  stage = Stage();
  stage.size_m = 1.4;
  stage.distance_m = 2.4;
  const Proposals furniture =
      Retrieve("furniture", StagedViews(Library().models[4].shape, stage), InputChannels::kColour);
  ASSERT_FALSE(furniture.candidates.empty());
  EXPECT_EQ(furniture.candidates.front().library_id, Library().models[4].id);
}

TEST(Retrieval, NoOutlineGivesANote) {
  EXPECT_THAT(Retrieve("chair", {}, InputChannels::kColour).notes, testing::SizeIs(1));
  std::vector<ObjectView> views = StagedViews(Library().models[0].shape, Stage());
  for (ObjectView& view : views) view.mask_crop = Mask(view.camera.width, view.camera.height, 0);
  EXPECT_TRUE(Retrieve("chair", views, InputChannels::kColour).candidates.empty());
  for (ObjectView& view : views) view.mask_crop = Mask();
  EXPECT_TRUE(Retrieve("chair", views, InputChannels::kColour).candidates.empty());
}

TEST(Retrieval, NothingSeenGivesANote) {
  EXPECT_THAT(Retrieve("chair", {}).notes, testing::SizeIs(1));
  std::vector<ObjectView> views = StagedViews(Library().models[0].shape, Stage());
  for (ObjectView& view : views) view.mask_crop = Mask(view.camera.width, view.camera.height, 0);
  const Proposals proposals = Retrieve("chair", views);
  EXPECT_TRUE(proposals.candidates.empty());
  EXPECT_THAT(proposals.notes, testing::SizeIs(1));
  for (ObjectView& view : views) view.depth_crop_m = DepthImage(2, 2, 1.0F);
  EXPECT_TRUE(Retrieve("chair", views).candidates.empty());
}

TEST(Retrieval, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<ObjectView> views = StagedViews(Library().models[2].shape, Stage());
  const auto scores = [&](int threads) {
    const ThreadLimit limit(threads);
    std::vector<std::pair<std::string, double>> result;
    for (const ShapeCandidate& c : Retrieve("chair", views).candidates) {
      result.emplace_back(c.model, c.proposal_score);
    }
    return result;
  };
  EXPECT_EQ(scores(1), scores(2));
}

Proposals Fuse(const std::string& class_name, std::span<const ObjectView> views) {
  const Result<Proposals> proposals =
      MakeFusedProposer(Classes())->Propose({ObjectId{7}, class_name, views});
  EXPECT_TRUE(proposals.ok());
  return *proposals;
}

// A box of 0.9 m height, seen from all sides, and what is fused of it.
class FusedBox {
 public:
  explicit FusedBox(const Eigen::Vector2f& sides_m, Stage from = {})
      : stage(from),
        box(*shape::Voxelize(testing_support::BoxMesh({sides_m.x(), sides_m.y(), 0.9F}))) {
    stage.size_m = 0.9;
    stage.sweep_rad = 5.5;
    proposals = Fuse("furniture", StagedViews(box, stage));
    EXPECT_EQ(proposals.candidates.size(), 1U);
  }
  [[nodiscard]] const ShapeCandidate& candidate() const { return proposals.candidates.at(0); }
  [[nodiscard]] const VoxelGrid& grid() const { return proposals.models.at(candidate().model); }

  Stage stage;
  VoxelGrid box;
  Proposals proposals;
};

TEST(Fused, IsLikeABoxSeenFromAllSides) {
  const FusedBox fused({0.5F, 0.7F}, {.num_views = 8});
  const ShapeCandidate& candidate = fused.candidate();
  const VoxelGrid& box = fused.box;
  EXPECT_EQ(candidate.source, CandidateSource::kFused);
  EXPECT_EQ(candidate.model, "fused_007");
  EXPECT_NEAR(candidate.size_m, 0.9, 0.035);  // a voxel on each side, and half of one of the test's
  const VoxelGrid& grid = fused.grid();
  const double overlap = std::max(shape::GridIntersectionOverUnion(grid, box),
                                  shape::GridIntersectionOverUnion(shape::TurnGrid(grid, 1), box));
  EXPECT_GT(overlap, 0.8);
  // It says where it was measured; which of two like sides is its front, a box does not tell.
  ASSERT_TRUE(candidate.world_from_object);
  const Similarity3 true_from_measured =
      (testing_support::StagedWorldFromLevel() *
       testing_support::StagedLevelFromObject(shape::ShapeModel(box), fused.stage))
          .Inverse() *
      *candidate.world_from_object;
  EXPECT_NEAR(true_from_measured.scale, 1, 0.05);
  EXPECT_LT(true_from_measured.translation_m.norm(), 0.04);
  const Eigen::Matrix3d turn = true_from_measured.rotation.toRotationMatrix();
  EXPECT_GT(turn(2, 2), 0.999);
  const shape::ShapeModel measured(grid);
  const bool is_turned_by_quarter = measured.extent().x() > measured.extent().y();
  EXPECT_NEAR(std::abs(turn(0, 0)), is_turned_by_quarter ? 0 : 1, 0.06);
}

TEST(Fused, KeepsTheSpaceUnderATableFree) {
  const VoxelGrid table = *shape::Voxelize(TableMesh(1.4F, 0.8F, 0.74F, 0.06F));
  Stage stage;
  stage.size_m = 1.4;
  stage.sweep_rad = 5.5;
  stage.num_views = 8;
  stage.distance_m = 2.4;
  const Proposals proposals = Fuse("table", StagedViews(table, stage));
  ASSERT_EQ(proposals.candidates.size(), 1U);
  const VoxelGrid& grid = proposals.models.begin()->second;
  const shape::ShapeModel model(grid);
  // Half-way between floor and top, at the middle.
  const Eigen::Vector3f under(0, 0, 0.5F * (model.box_min().z() + model.box_max().z()));
  EXPECT_GT(model.Distance(under), 0.05F);
}

// With the volume that it has, although the noise of its depth is about as large as a voxel.
TEST(Fused, EndsWhereTheSurfaceWasMeasured) {
  const FusedBox fused({0.3F, 0.4F}, {.num_views = 12, .distance_m = 2.6, .noise_m = 0.003});
  const auto count = std::ranges::count(fused.grid().occupied, std::uint8_t{1});
  const double voxel_m = fused.candidate().world_from_object->scale * kVoxelSize;
  EXPECT_NEAR(static_cast<double>(count) * std::pow(voxel_m, 3) / (0.3 * 0.4 * 0.9), 1, 0.2);
}

// A box seen from one side: its far half is solid where the class says so, else only a shell is.
TEST(Fused, FillsWhatNobodySawOfClosedFurniture) {
  const VoxelGrid box = *shape::Voxelize(testing_support::BoxMesh({0.5F, 0.7F, 0.9F}));
  Stage stage;
  stage.size_m = 0.9;
  stage.sweep_rad = 0.6;
  const std::vector<ObjectView> views = StagedViews(box, stage);
  const auto num_solid = [&](const char* class_name) {
    const Proposals proposals = Fuse(class_name, views);
    EXPECT_THAT(proposals.models, testing::SizeIs(1));
    const std::vector<std::uint8_t>& voxels = proposals.models.begin()->second.occupied;
    return std::count(voxels.begin(), voxels.end(), std::uint8_t{1});
  };
  EXPECT_GT(num_solid("furniture"), 2 * num_solid("chair"));
}

TEST(Fused, NothingSeenGivesANote) {
  EXPECT_TRUE(Fuse("chair", {}).candidates.empty());
  EXPECT_THAT(Fuse("chair", {}).notes, testing::SizeIs(1));
}

}  // namespace
}  // namespace deepslam::propose
