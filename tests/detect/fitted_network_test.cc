#include "deepslam/detect/fitted_network.h"

#include <cmath>

#include <gmock/gmock.h>

#include "deepslam/detect/detector.h"
#include "support/grid_onnx.h"
#include "support/tiny_onnx.h"

namespace deepslam::detect {
namespace {

using testing::Ge;
using testing::SizeIs;
using testing_support::GridNetwork;
using testing_support::TinyNetwork;
using testing_support::WriteOnnx;

TEST(FitSides, KeepsTheImagesScaleInMultiplesOfTheStride) {
  for (const Sides input : {Sides{640, 640}, Sides{640, 480}, Sides{1280, 320}}) {
    for (const Sides image : {Sides{640, 480},
                              Sides{480, 640},
                              Sides{1920, 1080},
                              Sides{1000, 17},
                              Sides{3, 2000},
                              Sides{641, 479},
                              Sides{1, 1}}) {
      const Sides fitted = FitSides(image, input);
      EXPECT_EQ(fitted.width % kCoarsestStride_px, 0);
      EXPECT_EQ(fitted.height % kCoarsestStride_px, 0);
      EXPECT_THAT(input.width - fitted.width, Ge(0));
      EXPECT_THAT(input.height - fitted.height, Ge(0));
      EXPECT_TRUE(fitted.width == input.width || fitted.height == input.height);
      const auto scale = [&](Sides sides) {
        return FitLetterbox(image.width, image.height, sides.width, sides.height, Padding::kCentred)
            .scale;
      };
      EXPECT_NEAR(scale(fitted), scale(input), 1e-9);
      // One stride less on either side would not hold it.
      EXPECT_LT(fitted.width - kCoarsestStride_px, image.width * scale(input));
      EXPECT_LT(fitted.height - kCoarsestStride_px, image.height * scale(input));
      EXPECT_EQ(FitSides(image, fitted), fitted);
    }
  }
  EXPECT_EQ(FitSides({}, {640, 480}), (Sides{640, 480}));
}

// Black, with a square of each colour where a cell lies.
ColourImage ThreeSquares(Sides sides) {
  ColourImage image(sides.width, sides.height);
  const auto paint = [&](int u0, int v0, int side, Rgb8 colour) {
    for (int v = v0; v < v0 + side; ++v) {
      for (int u = u0; u < u0 + side; ++u) image(u, v) = colour;
    }
  };
  paint(8, 16, 8, {255, 0, 0});
  paint(32, 32, 16, {0, 255, 0});
  paint(sides.width - 32, sides.height - 32, 32, {0, 0, 255});
  return image;
}

std::vector<RawDetection> Detections(const std::string& bytes, const ColourImage& image) {
  DetectorOptions options;
  options.min_score = 0.9;
  const auto detector = LoadNetworkDetector(bytes, options);
  EXPECT_TRUE(detector.ok()) << detector.error().message;
  if (!detector.ok()) return {};
  auto found = (*detector)->Detect(image);
  EXPECT_TRUE(found.ok()) << found.error().message;
  return found.ok() ? *std::move(found) : std::vector<RawDetection>();
}

void ExpectEqual(const std::vector<RawDetection>& found,
                 const std::vector<RawDetection>& expected) {
  ASSERT_THAT(found, SizeIs(expected.size()));
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].label, expected[i].label);
    EXPECT_EQ(found[i].score, expected[i].score);
    EXPECT_EQ(found[i].box_px, expected[i].box_px);
  }
}

TEST(FittedNetwork, FindsInLessInputWhatItFoundInASquare) {
  for (const auto constants : {GridNetwork::Constants::kInitializers,
                               GridNetwork::Constants::kNodes,
                               GridNetwork::Constants::kListed}) {
    GridNetwork network;
    network.constants = constants;
    const std::string square = WriteOnnx(network);
    for (const Sides sides : {Sides{128, 64}, Sides{64, 128}}) {
      const ColourImage image = ThreeSquares(sides);
      const auto expected = Detections(square, image);
      ASSERT_THAT(expected, SizeIs(Ge(3U)));
      const auto fitted = FittedNetwork(square, sides);
      ASSERT_TRUE(fitted.has_value());
      ExpectEqual(Detections(*fitted, image), expected);
      EXPECT_FALSE(FittedNetwork(*fitted, sides).has_value()) << "it fits already";
    }
  }
}

TEST(FittedNetwork, IsWhatADetectorRunsOnThoseImages) {
  DetectorOptions options;
  options.min_score = 0.9;
  options.images = {128, 64};
  const auto detector = LoadNetworkDetector(WriteOnnx(GridNetwork()), options);
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  const auto wide = (*detector)->Detect(ThreeSquares({128, 64}));
  ASSERT_TRUE(wide.ok());
  ExpectEqual(*wide, Detections(WriteOnnx(GridNetwork()), ThreeSquares({128, 64})));
  // A square comes to half its size in there.
  const auto square = (*detector)->Detect(ThreeSquares({128, 128}));
  ASSERT_TRUE(square.ok()) << square.error().message;
  ASSERT_THAT(*square, SizeIs(Ge(1U)));
  for (const RawDetection& detection : *square) EXPECT_NE(detection.label, "red");
}

TEST(FittedNetwork, ScalesLargerImages) {
  GridNetwork network;
  const Sides sides = {256, 128};
  const auto fitted = FittedNetwork(WriteOnnx(network), sides);
  ASSERT_TRUE(fitted.has_value());
  ExpectEqual(Detections(*fitted, ThreeSquares(sides)),
              Detections(WriteOnnx(network), ThreeSquares(sides)));
}

TEST(FittedNetwork, LeavesAloneWhatFitsOrIsNotKnown) {
  const std::string square = WriteOnnx(GridNetwork());
  EXPECT_FALSE(FittedNetwork(square, {128, 128}).has_value());
  EXPECT_FALSE(FittedNetwork(square, {}).has_value());
  GridNetwork by_columns;
  by_columns.cells_by_columns = true;
  EXPECT_FALSE(FittedNetwork(WriteOnnx(by_columns), {128, 64}).has_value());
  GridNetwork odd;
  odd.width = 100;
  EXPECT_FALSE(FittedNetwork(WriteOnnx(odd), {100, 50}).has_value());
  TinyNetwork open;
  open.input_shape = {1, 3, -1, -1};
  EXPECT_FALSE(FittedNetwork(WriteOnnx(open), {128, 64}).has_value());
  TinyNetwork two;
  two.inputs = {{"a", {1, 3, 64, 64}}, {"b", {1, 3, 64, 64}}};
  EXPECT_FALSE(FittedNetwork(WriteOnnx(two), {128, 64}).has_value());
  TinyNetwork flat;
  flat.input_shape = {1, 10};
  EXPECT_FALSE(FittedNetwork(WriteOnnx(flat), {128, 64}).has_value());
}

TEST(FittedNetwork, SurvivesDamagedFiles) {
  const std::string whole = WriteOnnx(GridNetwork());
  for (const char* text : {"", "this is a text file"})
    EXPECT_FALSE(FittedNetwork(text, {128, 64}).has_value());
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    const auto fitted = FittedNetwork(whole.substr(0, length), {128, 64});
    if (fitted.has_value()) {
      EXPECT_FALSE(LoadNetworkDetector(*fitted, {}).ok()) << length;
    }
  }
}

TEST(LoadNetworkDetector, TakesTheFileAsItIsWhereItCannotBeFitted) {
  GridNetwork network;
  network.expands = true;  // the sides stand where they are not looked for
  DetectorOptions options;
  options.min_score = 0.9;
  options.images = {128, 64};
  const auto detector = LoadNetworkDetector(WriteOnnx(network), options);
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  const auto found = (*detector)->Detect(ThreeSquares(options.images));
  ASSERT_TRUE(found.ok()) << found.error().message;
  ExpectEqual(*found, Detections(WriteOnnx(GridNetwork()), ThreeSquares(options.images)));
}

}  // namespace
}  // namespace deepslam::detect
