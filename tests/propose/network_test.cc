#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deepslam/geometry/upright.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/propose/proposer.h"
#include "deepslam/propose/shape_prior.h"
#include "deepslam/shape/stretch.h"
#include "deepslam/shape/voxelize.h"
#include "staged_views.h"
#include "support/box_meshes.h"
#include "support/tiny_onnx.h"

namespace deepslam::propose {
namespace {

using testing::HasSubstr;
using testing_support::ChairMesh;
using testing_support::StagedViews;
using testing_support::TinyNetwork;
using testing_support::WriteOnnx;

VoxelGrid Chair() { return *shape::Voxelize(ChairMesh(0.42F, 0.45F, 0.45F, 0.9F, 0.04F)); }

struct TinyPrior {
  TinyNetwork sketch;
  TinyNetwork encoder;
  TinyNetwork decoder;

  [[nodiscard]] Result<std::unique_ptr<ShapePrior>> Load(const std::string& name = "chair") const {
    return ShapePrior::Load(name, WriteOnnx(sketch), WriteOnnx(encoder), WriteOnnx(decoder));
  }
};

// Networks that answer every view with this shape, seen from azimuth bin `bin`.
TinyPrior PriorOf(const VoxelGrid& shape, int bin = 6) {
  TinyPrior prior;
  const TinyNetwork::Input crop = {"crop", {1, kCropPlanes, kCropSide, kCropSide}};
  const TinyNetwork::Input sketch = {"sketch", {1, 5, 64, 64}};
  const auto metadata = [](const char* role) {
    return std::map<std::string, std::string>{
        {"format", "deepslam/prior"}, {"version", "1"}, {"class", "chair"}, {"role", role}};
  };
  prior.sketch.inputs = {crop};
  prior.sketch.outputs = {{{1, 5, 64, 64}, std::vector<float>(5 * 64 * 64, 0.1F), "sketch"}};
  prior.sketch.metadata = metadata("sketch");
  std::vector<float> latents(kNumLatents);
  for (std::size_t n = 0; n < latents.size(); ++n) latents[n] = 0.01F * static_cast<float>(n);
  std::vector<float> azimuth(24, 0.0F);
  azimuth[static_cast<std::size_t>(bin)] = 9.0F;
  prior.encoder.inputs = {crop, sketch};
  prior.encoder.outputs = {
      {{1, 100}, latents, "latents"}, {{1, 24}, azimuth, "azimuth"}, {{1, 1}, {0.3F}, "elevation"}};
  prior.encoder.metadata = metadata("encoder");
  std::vector<float> logits;
  for (const std::uint8_t voxel : shape.occupied) logits.push_back(voxel != 0 ? 4.0F : -4.0F);
  prior.decoder.inputs = {{"latents", {1, 100}}};
  prior.decoder.outputs = {{{1, 64, 64, 64}, logits, "logits"}};
  prior.decoder.metadata = metadata("decoder");
  prior.decoder.metadata["threshold"] = "0.4";
  prior.decoder.metadata["threshold_colour"] = "0.3";
  return prior;
}

ClassTable Classes() {
  ClassTable table;
  ObjectClass chair;
  chair.name = "chair";
  chair.min_size_m = 0.45;
  chair.max_size_m = 1.5;
  table.classes = {chair};
  return table;
}

TEST(NetworkProposerTest, EveryViewProposesAndSoDoesTheirMean) {
  const VoxelGrid chair = Chair();
  Result<std::unique_ptr<ShapePrior>> prior = PriorOf(chair).Load();
  ASSERT_TRUE(prior) << prior.error().message;
  ShapePriors priors;
  priors.emplace("chair", std::move(*prior));
  NetworkOptions options;
  options.max_views = 8;
  const auto proposer = MakeNetworkProposer(priors, Classes(), options);
  const std::vector<ObjectView> views = StagedViews(chair, {});
  const Result<Proposals> proposals = proposer->Propose({ObjectId{3}, "chair", views});
  ASSERT_TRUE(proposals) << proposals.error().message;
  ASSERT_EQ(proposals->candidates.size(), views.size() + 1);
  std::size_t means = 0;
  for (const ShapeCandidate& candidate : proposals->candidates) {
    EXPECT_EQ(candidate.object, ObjectId{3});
    ASSERT_EQ(candidate.latents.size(), kNumLatents);
    EXPECT_NEAR(candidate.latents[50], 0.5F, 1e-5F);
    means += candidate.source == CandidateSource::kMeanLatent ? 1 : 0;
    ASSERT_TRUE(proposals->models.contains(candidate.model));
    EXPECT_GT(shape::GridIntersectionOverUnion(proposals->models.at(candidate.model), chair), 0.9);
    EXPECT_GT(candidate.size_m, 0.7) << "by the depth, of a chair of 1 m";
    EXPECT_LE(candidate.max_size_m, 1.5);
    EXPECT_GT(candidate.proposal_score, 0.9);
  }
  EXPECT_EQ(means, 1U);

  // Of fewer views offered, the shape of all together is what it was.
  options.max_views = 2;
  const Result<Proposals> fewer =
      MakeNetworkProposer(priors, Classes(), options)->Propose({ObjectId{3}, "chair", views});
  ASSERT_TRUE(fewer);
  ASSERT_EQ(fewer->candidates.size(), 3U);
  const auto of_all = [](const Proposals& p) {
    return std::ranges::find(p.candidates, CandidateSource::kMeanLatent, &ShapeCandidate::source);
  };
  ASSERT_NE(of_all(*fewer), fewer->candidates.end());
  EXPECT_EQ(of_all(*fewer)->latents, of_all(*proposals)->latents);
  EXPECT_EQ(of_all(*fewer)->size_m, of_all(*proposals)->size_m);

  const Result<Proposals> other = proposer->Propose({ObjectId{4}, "lamp", views});
  ASSERT_TRUE(other);
  EXPECT_TRUE(other->candidates.empty());
  ASSERT_EQ(other->notes.size(), 1U);
  EXPECT_THAT(other->notes[0], HasSubstr("no prior"));
}

TEST(NetworkProposerTest, TheShapeOfAllViewsTakesTheProportionsThatDepthHas) {
  const VoxelGrid chair = Chair();
  for (const Eigen::Vector3d& misread : {Eigen::Vector3d(1, 1, 1.5), Eigen::Vector3d(1.3, 1, 1)}) {
    ShapePriors priors;
    priors.emplace("chair", std::move(*PriorOf(shape::StretchGrid(chair, misread)).Load()));
    const std::vector<ObjectView> views = StagedViews(chair, {});
    const auto proposer = MakeNetworkProposer(priors, Classes(), {});
    const Result<Proposals> proposals = proposer->Propose({ObjectId{3}, "chair", views});
    ASSERT_TRUE(proposals) << proposals.error().message;
    const ShapeCandidate* joined = nullptr;
    const ShapeCandidate* fitted = nullptr;
    for (const ShapeCandidate& candidate : proposals->candidates) {
      if (candidate.source != CandidateSource::kMeanLatent) continue;
      (candidate.latents.empty() ? fitted : joined) = &candidate;
    }
    ASSERT_NE(joined, nullptr);
    ASSERT_NE(fitted, nullptr);
    const double before =
        shape::GridIntersectionOverUnion(proposals->models.at(joined->model), chair);
    const double after =
        shape::GridIntersectionOverUnion(proposals->models.at(fitted->model), chair);
    EXPECT_GT(after, before + 0.1);
    EXPECT_NEAR(fitted->size_m, 1, 0.1) << "a chair of 1 m";

    NetworkOptions options;
    options.fit_proportions = false;
    const Result<Proposals> without =
        MakeNetworkProposer(priors, Classes(), options)->Propose({ObjectId{3}, "chair", views});
    ASSERT_TRUE(without);
    EXPECT_EQ(without->candidates.size() + 1, proposals->candidates.size());
  }
}

TEST(NetworkProposerTest, ViewsWithoutASilhouetteGiveAReason) {
  const VoxelGrid chair = Chair();
  ShapePriors priors;
  priors.emplace("chair", std::move(*PriorOf(chair).Load()));
  const auto proposer =
      MakeNetworkProposer(std::move(priors), Classes(), {}, InputChannels::kColour);
  std::vector<ObjectView> views = StagedViews(chair, {});
  for (ObjectView& view : views) std::fill(view.mask_crop.begin(), view.mask_crop.end(), 0);
  const Result<Proposals> proposals = proposer->Propose({ObjectId{1}, "chair", views});
  ASSERT_TRUE(proposals);
  EXPECT_TRUE(proposals->candidates.empty());
  ASSERT_FALSE(proposals->notes.empty());
  EXPECT_THAT(proposals->notes[0], HasSubstr("silhouette"));
}

TEST(NetworkProposerTest, ViewsThatANetworkMisreadsFallAndGiveAReason) {
  const VoxelGrid chair = Chair();
  TinyPrior broken = PriorOf(chair);
  broken.encoder.outputs[0].values[7] = std::numeric_limits<float>::quiet_NaN();
  ShapePriors priors;
  priors.emplace("chair", std::move(*broken.Load()));
  const auto proposer = MakeNetworkProposer(std::move(priors), Classes(), {});
  const std::vector<ObjectView> views = StagedViews(chair, {});
  const Result<Proposals> proposals = proposer->Propose({ObjectId{3}, "chair", views});
  ASSERT_TRUE(proposals) << proposals.error().message;
  EXPECT_TRUE(proposals->candidates.empty());
  ASSERT_EQ(proposals->notes.size(), views.size());
  EXPECT_THAT(proposals->notes[0], HasSubstr("frame"));
  EXPECT_THAT(proposals->notes[0], HasSubstr("not finite"));
}

TEST(ShapePriorTest, SaysWhereTheCameraStands) {
  const Result<std::unique_ptr<ShapePrior>> prior = PriorOf(Chair(), 6).Load();
  ASSERT_TRUE(prior);
  const Result<NetworkCrop> crop = MakeNetworkCrop(StagedViews(Chair(), {})[0], true);
  ASSERT_TRUE(crop);
  const Result<PriorEncoding> encoding = (*prior)->Encode(*crop);
  ASSERT_TRUE(encoding);
  EXPECT_NEAR(encoding->azimuth_rad, 1.5708, 1e-3);
  EXPECT_NEAR(encoding->elevation_rad, 0.3, 1e-6);
  EXPECT_GT(encoding->confidence, 0.9);
}

// How far viewing rays run apart is known of every crop, how far the camera looks down where the
// ground is; networks may ask for the first or for both.
TEST(ShapePriorTest, TellsTheEncoderOfTheCamera) {
  const std::vector<ObjectView> views = StagedViews(Chair(), {});
  const Result<NetworkCrop> crop = MakeNetworkCrop(views[0], true);
  const Result<NetworkCrop> by_colour = MakeNetworkCrop(views[0], false);
  ASSERT_TRUE(crop && by_colour);
  EXPECT_NEAR(crop->camera.side, crop->side_m / crop->reference_m, 1e-9);
  EXPECT_NEAR(by_colour->camera.side, crop->camera.side, 1e-12);
  EXPECT_TRUE(crop->elevation_rad);
  EXPECT_FALSE(by_colour->elevation_rad);
  TinyPrior asks = PriorOf(Chair());
  asks.encoder.inputs.push_back({"spread", {1, 1}});
  const Result<std::unique_ptr<ShapePrior>> prior = asks.Load();
  ASSERT_TRUE(prior) << prior.error().message;
  EXPECT_TRUE((*prior)->Encode(*crop));
  asks.encoder.inputs.back() = {"sight", {1, 3}};
  const Result<std::unique_ptr<ShapePrior>> newer = asks.Load();
  ASSERT_TRUE(newer) << newer.error().message;
  EXPECT_TRUE((*newer)->Encode(*crop));
  EXPECT_TRUE((*newer)->Encode(*by_colour));
  asks.encoder.inputs.back().name = "width";
  EXPECT_THAT(asks.Load().error().message, HasSubstr("`spread`"));
  asks.encoder.inputs.back() = {"sight", {1, 1}};
  EXPECT_THAT(asks.Load().error().message, HasSubstr("`sight`"));
}

TEST(ShapePriorTest, RefusesWhatIsNoPrior) {
  const VoxelGrid chair = Chair();
  struct Case {
    const char* what;
    void (*spoil)(TinyPrior&);
    const char* message;
  };
  const std::vector<Case> cases = {
      {"no metadata", [](TinyPrior& p) { p.decoder.metadata.clear(); }, "metadata"},
      {"roles changed", [](TinyPrior& p) { std::swap(p.encoder, p.sketch); }, "metadata"},
      {"newer", [](TinyPrior& p) { p.sketch.metadata["version"] = "3"; }, "version '3'"},
      {"derivative promised and not there",
       [](TinyPrior& p) { p.decoder.metadata["version"] = "2"; },
       "`cotangent`"},
      {"another class", [](TinyPrior& p) { p.encoder.metadata["class"] = "sofa"; }, "sofa"},
      {"no threshold", [](TinyPrior& p) { p.decoder.metadata.erase("threshold"); }, "threshold"},
      {"threshold beyond",
       [](TinyPrior& p) { p.decoder.metadata["threshold_colour"] = "7"; },
       "threshold"},
      {"kept beyond",
       [](TinyPrior& p) { p.decoder.metadata["kept_of_expected_colour"] = "1.5"; },
       "kept_of_expected_colour"},
      {"kept in words",
       [](TinyPrior& p) { p.decoder.metadata["kept_of_expected"] = "half"; },
       "'half'"},
      {"smaller crop", [](TinyPrior& p) { p.sketch.inputs[0].shape[2] = 64; }, "`crop`"},
      {"fewer latents",
       [](TinyPrior& p) {
         p.encoder.outputs[0] = {{1, 5}, std::vector<float>(5), "latents"};
       },
       "`latents`"},
      {"output missing", [](TinyPrior& p) { p.encoder.outputs.pop_back(); }, "`elevation`"},
      {"one input too many",
       [](TinyPrior& p) {
         p.decoder.inputs.push_back({"more", {1}});
       },
       "2 inputs"},
  };
  for (const Case& c : cases) {
    TinyPrior prior = PriorOf(chair);
    c.spoil(prior);
    const Result<std::unique_ptr<ShapePrior>> loaded = prior.Load();
    ASSERT_FALSE(loaded) << c.what;
    EXPECT_EQ(loaded.error().code, ErrorCode::kInvalidInput) << c.what;
    EXPECT_THAT(loaded.error().message, HasSubstr(c.message)) << c.what;
  }
  for (const std::string& bytes :
       {std::string(), std::string("no network"), std::string(1000, '\x7f')}) {
    const auto loaded = ShapePrior::Load("chair", bytes, bytes, bytes);
    ASSERT_FALSE(loaded);
    EXPECT_THAT(loaded.error().message, HasSubstr("sketch.onnx"));
  }
  EXPECT_FALSE(PriorOf(chair).Load("sofa"));
}

TEST(ShapePriorTest, NothingThatIsNotFiniteBecomesVoxels) {
  const Result<NetworkCrop> crop = MakeNetworkCrop(StagedViews(Chair(), {})[0], true);
  ASSERT_TRUE(crop);
  TinyPrior prior = PriorOf(Chair());
  prior.decoder.outputs[0].values[1234] = std::numeric_limits<float>::quiet_NaN();
  prior.encoder.outputs[0].values[7] = std::numeric_limits<float>::infinity();
  const Result<std::unique_ptr<ShapePrior>> loaded = prior.Load();
  ASSERT_TRUE(loaded);
  EXPECT_FALSE((*loaded)->Encode(*crop));
  std::vector<float> latents(kNumLatents, 0.0F);
  EXPECT_FALSE((*loaded)->Decode(latents, true));
  const Result<std::unique_ptr<ShapePrior>> sound = PriorOf(Chair()).Load();
  ASSERT_TRUE(sound);
  EXPECT_TRUE((*sound)->Decode(latents, true));
  latents[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE((*sound)->Decode(latents, true));
  EXPECT_FALSE((*sound)->Decode(std::vector<float>(5), true));
  const Result<std::unique_ptr<ShapePrior>> empty = PriorOf(VoxelGrid()).Load();
  ASSERT_TRUE(empty);
  const Result<VoxelGrid> nothing = (*empty)->Decode(std::vector<float>(kNumLatents), true);
  ASSERT_FALSE(nothing);
  EXPECT_THAT(nothing.error().message, HasSubstr("no solid"));
}

TEST(ShapePriorTest, KnowsWhetherItsDecoderHasADerivative) {
  TinyPrior prior = PriorOf(Chair());
  const std::vector<float> latents(kNumLatents, 0.5F);
  const std::vector<float> by_logits(VoxelGrid().occupied.size(), 1.0F);
  const auto without = prior.Load();
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_FALSE((*without)->HasGradient());
  const auto refused = (*without)->LatentGradient(latents, by_logits);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("decoder_gradient.py"));

  prior.decoder.metadata["version"] = "2";
  prior.decoder.inputs.push_back({"cotangent", {-1, -1, -1, -1}});
  prior.decoder.outputs.push_back({{1, 100}, std::vector<float>(100, 0.25F), "latent_gradient"});
  const auto with = prior.Load();
  ASSERT_TRUE(with) << with.error().message;
  EXPECT_TRUE((*with)->HasGradient());
  const auto gradient = (*with)->LatentGradient(latents, by_logits);
  ASSERT_TRUE(gradient) << gradient.error().message;
  EXPECT_EQ(*gradient, std::vector<float>(kNumLatents, 0.25F));
  EXPECT_TRUE((*with)->Decode(latents, true)) << "logits alone are asked for with one number";
  EXPECT_FALSE((*with)->LatentGradient(latents, std::vector<float>(5)));
  EXPECT_FALSE((*with)->LatentGradient(std::vector<float>(5), by_logits));
  EXPECT_FALSE((*with)->Solid(std::vector<float>(5), true));
}

TEST(ShapePriorTest, SaysWhereTheDecodersGridLies) {
  // A box of 20 x 10 x 30 voxels in a corner of the decoder's grid.
  VoxelGrid cornered;
  for (int i = 5; i < 25; ++i) {
    for (int j = 40; j < 50; ++j) {
      for (int k = 2; k < 32; ++k) cornered.occupied[VoxelGrid::Index(i, j, k)] = 1;
    }
  }
  const auto prior = PriorOf(cornered).Load();
  ASSERT_TRUE(prior);
  const std::vector<float> latents(kNumLatents, 0.0F);
  const Result<Similarity3> object_from_decoded = (*prior)->ObjectFromDecoded(latents, true);
  const Result<VoxelGrid> canonical = (*prior)->Decode(latents, true);
  ASSERT_TRUE(object_from_decoded && canonical);
  EXPECT_NEAR(object_from_decoded->scale, 62.0 / 30, 0.04);
  const std::optional<VoxelBox> box = OccupiedBox(*canonical);
  ASSERT_TRUE(box);
  const auto expect_near = [](const Eigen::Vector3d& a, const Eigen::Array3i& b) {
    EXPECT_LT((a - VoxelGrid::Center(b.x(), b.y(), b.z())).norm(), 2.5 * kVoxelSize);
  };
  expect_near(*object_from_decoded * VoxelGrid::Center(5, 40, 2), box->low);
  expect_near(*object_from_decoded * VoxelGrid::Center(24, 49, 31), box->high);
  EXPECT_FALSE((*PriorOf(VoxelGrid()).Load())->ObjectFromDecoded(latents, true));
}

// The networks that come with the program: their derivative against differences.
TEST(ShapePriorTest, DerivativesOfTheShippedDecodersAreThoseOfTheirLogits) {
  const std::filesystem::path folder =
      std::filesystem::path(DEEPSLAM_SOURCE_DIR) / "configs" / "priors";
  int num_classes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const auto read = [&](const char* name) {
      std::ifstream file(entry.path() / name, std::ios::binary);
      return std::string(std::istreambuf_iterator<char>(file), {});
    };
    const auto prior = ShapePrior::Load(entry.path().filename().string(),
                                        read("sketch.onnx"),
                                        read("encoder.onnx"),
                                        read("decoder.onnx"));
    ASSERT_TRUE(prior) << prior.error().message;
    ASSERT_TRUE((*prior)->HasGradient()) << entry.path();
    ++num_classes;
    std::vector<float> latents(kNumLatents);
    std::vector<float> direction(kNumLatents);
    for (std::size_t n = 0; n < kNumLatents; ++n) {
      latents[n] = 2 * std::sin(static_cast<float>(n));
      direction[n] = std::cos(2.3F * static_cast<float>(n));
    }
    // A smooth function of the logits: their squares, scaled.
    const auto loss = [&](float step) {
      std::vector<float> moved = latents;
      for (std::size_t n = 0; n < kNumLatents; ++n) moved[n] += step * direction[n];
      const auto logits = (*prior)->Logits(moved);
      EXPECT_TRUE(logits);
      double sum = 0;
      for (const float logit : *logits) sum += 0.5 * static_cast<double>(logit) * logit;
      return sum / static_cast<double>(logits->size());
    };
    std::vector<float> by_logits = *(*prior)->Logits(latents);
    for (float& value : by_logits) value /= static_cast<float>(by_logits.size());
    const auto gradient = (*prior)->LatentGradient(latents, by_logits);
    ASSERT_TRUE(gradient) << gradient.error().message;
    double expected = 0;
    double norm = 0;
    for (std::size_t n = 0; n < kNumLatents; ++n) {
      expected += static_cast<double>((*gradient)[n]) * direction[n];
      norm += static_cast<double>((*gradient)[n]) * (*gradient)[n];
    }
    const float step = 2e-3F;
    const double slope = (loss(step) - loss(-step)) / (2 * static_cast<double>(step));
    EXPECT_GT(norm, 0);
    EXPECT_NEAR(slope, expected, 0.02 * std::sqrt(norm) * std::sqrt(kNumLatents / 2.0))
        << entry.path();
  }
  EXPECT_GE(num_classes, 5);
}

class CropTest : public testing::Test {
 protected:
  static ObjectView View(int width, int height) {
    ObjectView view;
    view.colour_crop = ColourImage(width, height, {10, 200, 30});
    view.depth_crop_m = DepthImage(width, height, 2.0F);
    view.mask_crop = Mask(width, height, 1);
    view.camera = {width, height, 500, 500, 0.5 * (width - 1), 0.5 * (height - 1)};
    view.ground_camera = Plane{{0, -1, 0}, 1.2};  // level camera at 1.2 m
    return view;
  }
};

TEST_F(CropTest, WhiteOutsideAndSquare) {
  ObjectView view = View(60, 100);
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 60; ++u)
      view.mask_crop(u, v) = u >= 20 && u < 40 && v >= 10 && v < 90 ? 1 : 0;
  }
  const Result<NetworkCrop> crop = MakeNetworkCrop(view, true);
  ASSERT_TRUE(crop);
  EXPECT_NEAR(crop->camera.side, 88 / 500.0, 1e-3)
      << "the square, a tenth wider than the silhouette";
  EXPECT_EQ(crop->colour(0, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(crop->colour(64, 64), (Rgb8{10, 200, 30}));
  EXPECT_EQ(crop->silhouette(64, 64), 255);
  EXPECT_EQ(crop->depth(64, 64), 128) << "all of one depth: at the reference";
  EXPECT_EQ(crop->depth(0, 0), 0);
  EXPECT_NEAR(crop->side_m, 88 * 2.0 / 500, 5e-3);
  EXPECT_NEAR(crop->height(64, 64), 130, 3) << "1.2 m above the ground, in cm from -10";
  EXPECT_GT(crop->height(64, 20), crop->height(64, 110)) << "higher above";
  std::vector<float> planes(kCropValues);
  FillPlanes(*crop, planes);
  const std::size_t at = 64 * kCropSide + 64;
  constexpr std::size_t kPixels = static_cast<std::size_t>(kCropSide) * kCropSide;
  EXPECT_NEAR(planes[kPixels + at], 200.0F / 255, 1e-6F);
  EXPECT_NEAR(planes[4 * kPixels + at], 0, 1e-6F);
  EXPECT_NEAR(planes[5 * kPixels + at], 1.2F, 0.03F);
  EXPECT_EQ(planes[6 * kPixels + at], 1.0F);
}

// As the camera would have taken it turned; its ground and how it stands are as they were.
ObjectView HeldTurned(const ObjectView& view, QuarterTurn held) {
  ObjectView lying = view;
  lying.colour_crop = Turned(view.colour_crop, held);
  lying.depth_crop_m = Turned(view.depth_crop_m, held);
  lying.mask_crop = Turned(view.mask_crop, held);
  lying.camera = Turned(view.camera, held);
  return lying;
}

TEST_F(CropTest, WithoutAGroundStandsAsThePictureIsSaidTo) {
  ObjectView view = View(60, 100);
  view.ground_camera.reset();
  for (int v = 10; v < 90; ++v) {
    for (int u = 20; u < 40; ++u) view.mask_crop(u, v) = 1;
  }
  const Result<NetworkCrop> upright = MakeNetworkCrop(view, false);
  ASSERT_TRUE(upright);
  for (const QuarterTurn held :
       {QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise}) {
    ObjectView lying = HeldTurned(view, held);
    lying.upright = Inverse(held);
    const Result<NetworkCrop> crop = MakeNetworkCrop(lying, false);
    ASSERT_TRUE(crop);
    for (const auto& axis : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
      const Eigen::Vector3d of_lying = crop->camera.view_from_crop * axis;
      const Eigen::Vector3d of_standing = upright->camera.view_from_crop * axis;
      EXPECT_LT((of_lying - Turned(of_standing, held)).norm(), 1e-9);
    }
  }
}

TEST_F(CropTest, StandsUprightHoweverTheCameraIsHeld) {
  ObjectView view = View(60, 100);
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 60; ++u) {
      view.mask_crop(u, v) = u >= 20 && u < 40 + v / 10 && v >= 10 && v < 90 ? 1 : 0;
      view.colour_crop(u, v) = {
          static_cast<std::uint8_t>(2 * u), static_cast<std::uint8_t>(2 * v), 9};
      view.depth_crop_m(u, v) = 2.0F + 0.001F * static_cast<float>(u + 3 * v);
    }
  }
  const Result<NetworkCrop> upright = MakeNetworkCrop(view, true);
  ASSERT_TRUE(upright);
  for (const QuarterTurn held :
       {QuarterTurn::kClockwise, QuarterTurn::kHalf, QuarterTurn::kAnticlockwise}) {
    ObjectView lying = HeldTurned(view, held);
    lying.ground_camera = Turned(*view.ground_camera, held);
    const Result<NetworkCrop> crop = MakeNetworkCrop(lying, true);
    ASSERT_TRUE(crop);
    // But for places that fall between two pixels, and the last digit of a colour.
    const auto differ = [](const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
      int count = 0;
      for (std::size_t n = 0; n < a.size(); ++n)
        count += std::abs(a.data()[n] - b.data()[n]) > 1 ? 1 : 0;
      return count;
    };
    constexpr int kFew = kCropSide * kCropSide / 500;
    EXPECT_LE(differ(crop->silhouette, upright->silhouette), kFew);
    EXPECT_LE(differ(crop->depth, upright->depth), kFew);
    EXPECT_LE(differ(crop->height, upright->height), kFew);
    int other_colour = 0;
    for (std::size_t n = 0; n < crop->colour.size(); ++n) {
      const Rgb8& a = crop->colour.data()[n];
      const Rgb8& b = upright->colour.data()[n];
      other_colour += std::abs(a.r - b.r) + std::abs(a.g - b.g) > 2 ? 1 : 0;
    }
    EXPECT_LE(other_colour, kFew);
  }
}

// Where an object lies in the picture and how the camera was held say nothing of its shape: the
// crop is that of a camera that looks at it and is level.
TEST_F(CropTest, DoesNotDependOnWhereTheCameraLooks) {
  testing_support::Stage stage;
  stage.num_views = 1;
  stage.distance_m = 3.5;
  const auto crop_of = [&](const Eigen::Vector3d& turned_deg) {
    stage.turned_rad = std::numbers::pi / 180 * turned_deg;
    const Result<NetworkCrop> crop = MakeNetworkCrop(StagedViews(Chair(), stage)[0], true);
    EXPECT_TRUE(crop);
    return *crop;
  };
  const NetworkCrop straight = crop_of({0, 0, 0});
  ASSERT_TRUE(straight.elevation_rad);
  EXPECT_NEAR(*straight.elevation_rad, std::atan2(1.0, 3.5), 0.03);
  for (const Eigen::Vector3d& turned_deg : {Eigen::Vector3d(16, 0, 0),
                                            Eigen::Vector3d(-14, 10, 0),
                                            Eigen::Vector3d(0, -12, 25),
                                            Eigen::Vector3d(15, 5, -160)}) {
    const NetworkCrop aside = crop_of(turned_deg);
    EXPECT_NEAR(aside.camera.side, straight.camera.side, 0.04 * straight.camera.side);
    EXPECT_NEAR(*aside.elevation_rad, *straight.elevation_rad, 0.01);
    EXPECT_NEAR(aside.reference_m, straight.reference_m, 0.02);
    int both = 0;
    int either = 0;
    double apart = 0;
    for (int y = 0; y < kCropSide; ++y) {
      for (int x = 0; x < kCropSide; ++x) {
        const bool in_straight = straight.depth(x, y) != 0;
        const bool in_aside = aside.depth(x, y) != 0;
        either += in_straight || in_aside ? 1 : 0;
        if (!in_straight || !in_aside) continue;
        ++both;
        apart += std::abs(straight.depth(x, y) - aside.depth(x, y));
      }
    }
    EXPECT_GT(both, 0.8 * either) << turned_deg.transpose();
    EXPECT_LT(apart / both, 3.0) << turned_deg.transpose();
  }
}

TEST_F(CropTest, WithoutGroundTheCropIsHeldAsTheCamera) {
  ObjectView view = View(80, 80);
  const Result<NetworkCrop> level = MakeNetworkCrop(view, true);
  view.ground_camera.reset();
  const Result<NetworkCrop> held = MakeNetworkCrop(view, true);
  ASSERT_TRUE(level && held);
  EXPECT_EQ(held->colour, level->colour);
  EXPECT_FALSE(held->elevation_rad);
  view.ground_camera = Plane{{0, 0, -1}, 1.2};  // straight down
  const Result<NetworkCrop> down = MakeNetworkCrop(view, true);
  ASSERT_TRUE(down);
  EXPECT_EQ(down->colour, level->colour) << "no way is up";
  EXPECT_NEAR(*down->elevation_rad, std::numbers::pi / 2, 1e-6);
}

TEST_F(CropTest, ByColourAloneTheDepthPlanesAreEmpty) {
  const Result<NetworkCrop> crop = MakeNetworkCrop(View(80, 80), false);
  ASSERT_TRUE(crop);
  EXPECT_EQ(crop->depth, Image<std::uint8_t>(kCropSide, kCropSide));
  EXPECT_EQ(crop->height, Image<std::uint8_t>(kCropSide, kCropSide));
  EXPECT_EQ(crop->side_m, 0);
}

TEST_F(CropTest, OddInputs) {
  ObjectView empty = View(50, 50);
  std::fill(empty.mask_crop.begin(), empty.mask_crop.end(), 0);
  EXPECT_FALSE(MakeNetworkCrop(empty, true));
  EXPECT_FALSE(MakeNetworkCrop(View(1, 1), true)) << "one pixel shows no shape";
  EXPECT_FALSE(MakeNetworkCrop(ObjectView(), true));
  ObjectView blunt = View(50, 50);
  blunt.camera.fx = 0;
  EXPECT_FALSE(MakeNetworkCrop(blunt, true)) << "no focal length";
  ObjectView uneven = View(50, 50);
  uneven.depth_crop_m = DepthImage(20, 50, 1.0F);
  EXPECT_FALSE(MakeNetworkCrop(uneven, true));
  EXPECT_TRUE(MakeNetworkCrop(View(3000, 2000), true)) << "huge";
  ObjectView white = View(50, 50);
  std::fill(white.colour_crop.begin(), white.colour_crop.end(), Rgb8{255, 255, 255});
  EXPECT_TRUE(MakeNetworkCrop(white, true)) << "a white object is told by its silhouette";
  ObjectView blind = View(50, 50);
  std::fill(blind.depth_crop_m.begin(), blind.depth_crop_m.end(), 0.0F);
  const Result<NetworkCrop> crop = MakeNetworkCrop(blind, true);
  ASSERT_TRUE(crop) << "no depth at all is a view by colour";
  EXPECT_EQ(crop->reference_m, 0);
  std::vector<float> planes(kCropValues);
  FillPlanes(*crop, planes);
  EXPECT_TRUE(std::all_of(planes.begin(), planes.end(), [](float v) { return std::isfinite(v); }));
}

}  // namespace
}  // namespace deepslam::propose
