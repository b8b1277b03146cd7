#include "deepslam/detect/yolo_heads.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>

namespace deepslam::detect {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using Shapes = std::vector<std::vector<std::int64_t>>;

constexpr int kCells64 = 64 + 16 + 4;  // cells of an input of 64 x 64 at strides 8, 16, 32

HeadLayout Layout(HeadKind kind, int num_classes, int num_coefficients = 0) {
  HeadLayout layout;
  layout.kind = kind;
  layout.num_classes = num_classes;
  layout.num_coefficients = num_coefficients;
  layout.num_cells = kCells64;
  layout.prototype_width = 16;
  layout.prototype_height = 16;
  layout.input_width = 64;
  layout.input_height = 64;
  return layout;
}

TEST(RecogniseHead, KnowsTheFamilyByShapes) {
  const auto v8 = RecogniseHead(Shapes{{1, 84, 8400}}, 80, 640, 640);
  ASSERT_TRUE(v8.ok());
  EXPECT_EQ(v8->kind, HeadKind::kYoloV8);
  EXPECT_EQ(v8->num_classes, 80);
  const auto seg = RecogniseHead(Shapes{{1, 116, 8400}, {1, 32, 160, 160}}, 80, 640, 640);
  ASSERT_TRUE(seg.ok());
  EXPECT_EQ(seg->kind, HeadKind::kYoloV8Seg);
  EXPECT_EQ(seg->num_classes, 80);
  EXPECT_EQ(seg->num_coefficients, 32);
  const auto yolox = RecogniseHead(Shapes{{1, 8400, 85}}, 0, 640, 640);
  ASSERT_TRUE(yolox.ok());
  EXPECT_EQ(yolox->kind, HeadKind::kYoloX);
  EXPECT_EQ(yolox->num_classes, 80);
  EXPECT_TRUE(RecogniseHead(Shapes{{1, 84, 3549}}, 80, 416, 416).ok());
}

TEST(RecogniseHead, NamesTheShapesItDoesNotKnow) {
  const std::vector<Shapes> foreign = {
      {},
      {{}},
      {{1, 1000}},
      {{1, 300, 6}},
      {{1, 56, 8400}},   // a pose network with one class
      {{1, 25200, 85}},  // YOLOv5
      {{2, 84, 8400}},
      {{1, 84, -1}},
      {{1, 116, 8400}, {1, 32, 0, 160}},
      {{1, 20, 8400}, {1, 32, 160, 160}}};  // fewer rows than coefficients
  for (const Shapes& shapes : foreign) {
    const auto layout = RecogniseHead(shapes, 1, 640, 640);
    ASSERT_FALSE(layout.ok());
    EXPECT_EQ(layout.error().code, ErrorCode::kInvalidInput);
  }
  EXPECT_THAT(RecogniseHead(Shapes{{1, 25200, 85}}, 80, 640, 640).error().message,
              HasSubstr("1x25200x85"));
}

TEST(DecodeHead, ReadsYoloV8ByColumns) {
  const HeadLayout layout = Layout(HeadKind::kYoloV8, 2);
  std::vector<float> output(6 * kCells64, 0.0F);
  const auto set = [&](int cell, std::array<float, 6> column) {
    for (int row = 0; row < 6; ++row) {
      output[static_cast<std::size_t>(row * kCells64 + cell)] =
          column[static_cast<std::size_t>(row)];
    }
  };
  set(3, {30, 20, 10, 8, 0.2F, 0.7F});
  set(80, {40, 44, 20, 10, 0.9F, 0.1F});
  set(5, {40, 44, -4, 10, 0.9F, 0.1F});  // no area
  set(6, {std::numeric_limits<float>::quiet_NaN(), 44, 4, 10, 0.9F, 0.1F});
  set(7, {40, 44, 4, 10, std::numeric_limits<float>::infinity(), 0.1F});
  const auto boxes = DecodeHead(output, layout, 0.3);
  ASSERT_THAT(boxes, SizeIs(2));
  EXPECT_EQ(boxes[0].label_idx, 0);
  EXPECT_NEAR(boxes[0].score, 0.9, 1e-6);
  EXPECT_EQ(boxes[0].box_input, (Box2{30, 39, 50, 49}));
  EXPECT_EQ(boxes[1].label_idx, 1);
  EXPECT_EQ(boxes[1].box_input, (Box2{25, 16, 35, 24}));
}

// Rows of a YOLOX head with one object at the given cell, in pixels or relative to that
// cell.
std::vector<float> YoloXOutput(bool relative) {
  std::vector<float> output(7 * kCells64, 0.0F);
  int cell = 0;
  for (const int stride : {8, 16, 32}) {
    for (int y = 0; y < 64 / stride; ++y) {
      for (int x = 0; x < 64 / stride; ++x, ++cell) {
        float* row = output.data() + 7 * cell;
        const auto side = static_cast<float>(stride);
        row[0] = relative ? 0.5F : (static_cast<float>(x) + 0.5F) * side;
        row[1] = relative ? 0.25F : (static_cast<float>(y) + 0.25F) * side;
        row[2] = relative ? std::log(2.0F) : 2.0F * side;
        row[3] = relative ? std::log(1.5F) : 1.5F * side;
        row[6] = 1.0F;
      }
    }
  }
  float* object = output.data() + 7 * (64 + 4 * 2 + 1);  // stride 16, cell (1, 2)
  object[4] = 0.9F;
  object[5] = 0.2F;
  object[6] = 0.8F;
  return output;
}

TEST(DecodeHead, ReadsYoloXOnGridsAndInPixelsAlike) {
  for (const bool relative : {true, false}) {
    const auto boxes = DecodeHead(YoloXOutput(relative), Layout(HeadKind::kYoloX, 2), 0.3);
    ASSERT_THAT(boxes, SizeIs(1)) << "relative " << relative;
    EXPECT_EQ(boxes[0].label_idx, 1);
    EXPECT_NEAR(boxes[0].score, 0.9 * 0.8, 1e-6);
    EXPECT_NEAR(boxes[0].box_input.u_min, 24.0 - 16.0, 1e-4);
    EXPECT_NEAR(boxes[0].box_input.u_max, 24.0 + 16.0, 1e-4);
    EXPECT_NEAR(boxes[0].box_input.v_min, 36.0 - 12.0, 1e-4);
    EXPECT_NEAR(boxes[0].box_input.v_max, 36.0 + 12.0, 1e-4);
  }
}

TEST(DecodeHead, BearsGarbageInYoloX) {
  std::vector<float> output(7 * kCells64, std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(DecodeHead(output, Layout(HeadKind::kYoloX, 2), 0.3), IsEmpty());
  std::fill(output.begin(), output.end(), std::numeric_limits<float>::infinity());
  EXPECT_THAT(DecodeHead(output, Layout(HeadKind::kYoloX, 2), 0.3), IsEmpty());
}

TEST(DecodeHead, ReadsMaskCoefficients) {
  const HeadLayout layout = Layout(HeadKind::kYoloV8Seg, 1, 2);
  std::vector<float> output(7 * kCells64, 0.0F);
  const std::array<float, 7> column = {30, 20, 10, 8, 0.8F, -3, 5};
  for (std::size_t row = 0; row < 7; ++row) output[row * kCells64 + 9] = column[row];
  const auto boxes = DecodeHead(output, layout, 0.3);
  ASSERT_THAT(boxes, SizeIs(1));
  EXPECT_THAT(boxes[0].coefficients, ElementsAre(-3, 5));
}

TEST(SuppressOverlaps, KeepsTheBestOfEachLabel) {
  const Box2 box = {0, 0, 10, 10};
  const Box2 near = {1, 0, 11, 10};
  const Box2 far = {20, 0, 30, 10};
  const auto kept = SuppressOverlaps(
      {{0, 0.9, box, {}}, {1, 0.8, near, {}}, {0, 0.7, near, {}}, {0, 0.6, far, {}}}, 0.5, 100);
  ASSERT_THAT(kept, SizeIs(3));
  EXPECT_EQ(kept[1].label_idx, 1);
  EXPECT_EQ(kept[2].box_input, far);
  EXPECT_THAT(SuppressOverlaps({{0, 0.9, box, {}}, {0, 0.6, far, {}}}, 0.5, 1), SizeIs(1));
}

TEST(DecodeInstanceMask, UpsamplesTheSumOfPrototypes) {
  const HeadLayout layout = Layout(HeadKind::kYoloV8Seg, 1, 2);
  // The first prototype is positive in the left half, the second everywhere.
  std::vector<float> prototypes(2 * 256, 1.0F);
  for (std::size_t i = 0; i < 256; ++i) prototypes[i] = i % 16 < 8 ? 1.0F : -1.0F;
  const Letterbox letterbox = FitLetterbox(128, 128, 64, 64, Padding::kCentred);
  const Mask mask = DecodeInstanceMask(
      std::vector<float>{2.0F, 0.0F}, prototypes, layout, letterbox, {10, 20, 100, 90}, 128, 128);
  EXPECT_EQ(mask(11, 50), 1);
  EXPECT_EQ(mask(62, 50), 1);
  EXPECT_EQ(mask(66, 50), 0) << "right of the middle the logit is negative";
  EXPECT_EQ(mask(30, 10), 0) << "outside the box";
  EXPECT_EQ(mask(5, 50), 0) << "outside the box";
}

TEST(Letterbox, BringsBoxesBack) {
  // 320 x 240 in 640 x 640: twice as large, 80 rows of padding above.
  const Letterbox centred = FitLetterbox(320, 240, 640, 640, Padding::kCentred);
  EXPECT_EQ(centred.pad_v_px, 80);
  const Box2 whole = ToImage(centred, {0, 80, 640, 560}, 320, 240);
  EXPECT_EQ(whole, (Box2{0, 0, 319, 239}));
  const Box2 part = ToImage(centred, {100, 180, 200, 280}, 320, 240);
  EXPECT_EQ(part, (Box2{49.5, 49.5, 99.5, 99.5}));
  EXPECT_TRUE(ToImage(centred, {0, 0, 640, 60}, 320, 240).empty()) << "only padding";
  EXPECT_EQ(FitLetterbox(320, 240, 640, 640, Padding::kTopLeft).pad_v_px, 0);
  EXPECT_EQ(FitLetterbox(100000, 1, 640, 640, Padding::kCentred).height_px, 1);
}

TEST(ParseNames, ReadsPythonAndJson) {
  EXPECT_THAT(ParseNames("{0: 'chair', 1: 'dining table'}"), ElementsAre("chair", "dining table"));
  EXPECT_THAT(ParseNames(R"({"0": "chair", "1": "chef's table"})"),
              ElementsAre("chair", "chef's table"));
  EXPECT_THAT(ParseNames(R"(['a', "b"])"), ElementsAre("a", "b"));
  EXPECT_THAT(ParseNames(R"({0: 'it\'s'})"), ElementsAre("it's"));
  for (const char* broken : {"", "chair", "{", "{0: 'chair", "{0: }", "3"}) {
    EXPECT_THAT(ParseNames(broken), IsEmpty()) << broken;
  }
}

TEST(CocoLabels, AreTheEighty) {
  EXPECT_THAT(CocoLabels(), SizeIs(80));
  EXPECT_EQ(CocoLabels()[56], "chair");
  EXPECT_EQ(CocoLabels()[60], "dining table");
}

}  // namespace
}  // namespace deepslam::detect
