#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "artifact/sample_values.h"
#include "deepslam/artifact/coco_file.h"
#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/frames/run_lengths.h"

namespace deepslam::artifact {
namespace {

using testing::HasSubstr;
using testing_support::SampleMask;

std::vector<DetectedImage> Images() {
  return {{FrameIdx{0}, "rgb/a.png", 64, 48},
          {FrameIdx{1}, "rgb/b.png", 64, 48},
          {FrameIdx{2}, "rgb/c.png", 64, 48}};
}

Result<CocoDetections> Read(const std::string& text) {
  return ReadCocoFile([&] { return Result<TextSource>(text); },
                      "boxes.json",
                      Images(),
                      class_table::DefaultClassTable());
}

// Known strings of pycocotools for a 3 x 2 (width x height) mask.
TEST(Rle, IsTheCodeOfPycocotools) {
  Mask mask(3, 2);
  mask(1, 0) = mask(1, 1) = mask(2, 0) = 1;  // column-major: 0 0 1 1 1 0
  EXPECT_EQ(EncodeRle(mask), "231");
  EXPECT_EQ(EncodeRle(Mask(3, 2)), "6");
  EXPECT_EQ(EncodeRle(Mask(3, 2, 1)), "06");
}

TEST(Rle, ReadsBackEveryMask) {
  for (const int width : {1, 7, 64, 640}) {
    for (const int height : {1, 5, 48, 480}) {
      const Mask mask = SampleMask(width, height);
      const Result<Mask> read = DecodeRle(EncodeRle(mask), width, height);
      ASSERT_TRUE(read.ok()) << width << " x " << height << ": " << read.error().message;
      EXPECT_EQ(*read, mask);
    }
  }
}

TEST(Rle, RefusesHostileCounts) {
  EXPECT_FALSE(DecodeRle("6", 1 << 20, 1 << 20).ok());
  EXPECT_FALSE(DecodeRle("6", -1, 5).ok());
  EXPECT_FALSE(DecodeRle("6", 4, 2).ok()) << "too short";
  EXPECT_FALSE(DecodeRle("7", 3, 2).ok()) << "too long";
  EXPECT_FALSE(DecodeRle("oooooooooooooooooo", 3, 2).ok()) << "number without end";
  EXPECT_FALSE(DecodeRle("2\x01", 3, 2).ok());
  EXPECT_FALSE(DecodeRle("2O", 3, 2).ok()) << "negative run";
  EXPECT_FALSE(DecodeRle("", 3, 2).ok());
}

TEST(Rle, RefusesRunsThatDoNotFillTheMask) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  const auto accepts = [](const std::vector<std::int64_t>& runs, int width = 3) {
    return RleOfRuns(runs, width, 2).ok();
  };
  EXPECT_TRUE(accepts({2, 3, 1}));
  EXPECT_FALSE(accepts({}));
  EXPECT_FALSE(accepts({2, 3}));
  EXPECT_FALSE(accepts({2, 3, 2}));
  EXPECT_FALSE(accepts({2, -3, 7}));
  EXPECT_FALSE(accepts({kMost, kMost, 8}));
  EXPECT_FALSE(accepts({-kMost - 1, kMost, 7}));
  EXPECT_FALSE(accepts({6}, -3));
}

std::string EntryWithCounts(const std::string& counts) {
  return R"([{"image_id": 1, "category_id": 62, "bbox": [1, 2, 30, 20],
              "segmentation": {"size": [48, 64], "counts": )" +
         counts + "}}]";
}

// One mask in COCO's two notations.
TEST(CocoFile, ReadsRunsAsListsToo) {
  Mask mask(64, 48);
  for (int u = 10; u < 20; ++u) {
    for (int v = 5; v < 30; ++v) mask(u, v) = 1;
  }
  std::string runs = fmt::format("[{}", 10 * 48 + 5);
  for (int u = 10; u < 19; ++u) runs += ", 25, 23";
  runs += fmt::format(", 25, {}]", 44 * 48 + 18);
  for (const std::string& counts : {runs, "\"" + EncodeRle(mask) + "\""}) {
    const Result<CocoDetections> read = Read(EntryWithCounts(counts));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_THAT(read->warnings, testing::IsEmpty());
    ASSERT_EQ(read->detections.size(), 1U);
    EXPECT_EQ(read->detections[0].mask.Unpacked(), mask) << counts;
  }
  const Result<CocoDetections> whole = Read(EntryWithCounts("[0, 3072]"));
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  EXPECT_EQ(whole->detections[0].mask.Unpacked(), Mask(64, 48, 1));
}

TEST(CocoFile, HostileRunsLeaveTheBoxInForce) {
  for (const char* counts : {"[]",
                             "[3071]",
                             "[3072, 1]",
                             "[0, 3073]",
                             "[-1, 3073]",
                             "[10, -5, 3067]",
                             "[0.5, 3071.5]",
                             "[1e300]",
                             "[9223372036854775807, 9223372036854775807, 3074]",
                             "[\"0\", 3072]",
                             "[null, 3072]",
                             "[[0], 3072]",
                             "{}",
                             "null",
                             "3072"}) {
    const Result<CocoDetections> read = Read(EntryWithCounts(counts));
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->detections.size(), 1U) << counts;
    EXPECT_TRUE(read->detections[0].mask.empty()) << counts;
    EXPECT_THAT(read->warnings, testing::ElementsAre(HasSubstr("[0].segmentation"))) << counts;
  }
}

// What entries mean may stand before or behind them.
TEST(CocoFile, ReadsMembersInAnyOrder) {
  const std::vector<std::string> members = {
      R"("images": [{"id": 7, "file_name": "other/b.jpg", "width": 128, "height": 96}])",
      R"("categories": [{"id": 1, "name": "couch"}])",
      R"("annotations": [{"image_id": 7, "category_id": 1, "bbox": [20, 10, 60, 40]}])"};
  std::vector<std::size_t> order = {0, 1, 2};
  do {
    const Result<CocoDetections> read =
        Read("{" + members[order[0]] + "," + members[order[1]] + "," + members[order[2]] + "}");
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->detections.size(), 1u);
    EXPECT_EQ(read->detections[0].frame, FrameIdx{1});
    EXPECT_EQ(read->detections[0].class_name, "sofa");
    EXPECT_NEAR(read->detections[0].box_px.u_min, 9.75, 1e-9) << "half the image's size";
  } while (std::ranges::next_permutation(order).found);
}

TEST(CocoFile, WithoutCategoriesOfItsOwnHasThoseOfCoco) {
  const std::string entries =
      R"("annotations": [{"image_id": 1, "category_id": 62, "bbox": [1, 2, 30, 20]}])";
  EXPECT_EQ(Read("{" + entries + "}")->detections.size(), 1u);
  const Result<CocoDetections> none = Read("{" + entries + R"(, "categories": []})");
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->losses.Of(CocoFault::kNamelessCategory).num_entries, 1);
}

TEST(CocoFile, ManyEntriesComeInTheirOrderWithTheirPlaces) {
  std::string text = "[";
  for (int k = 0; k < 5000; ++k)
    text += fmt::format(R"({{"image_id": {}, "category_id": 62, "bbox": [1, 2, 30, 20]}},)", k % 2);
  const Result<CocoDetections> read = Read(text + "3]");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->detections.size(), 5000u);
  EXPECT_THAT(read->warnings, testing::ElementsAre("[5000] is no object"));
}

TEST(CocoFile, PassesOnThatItCannotBeOpened) {
  const Result<CocoDetections> read =
      ReadCocoFile([] { return Result<TextSource>(InvalidInput("boxes.json: is not a file")); },
                   "boxes.json",
                   Images(),
                   class_table::DefaultClassTable());
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().message, "boxes.json: is not a file");
}

TEST(CocoFile, ReadsResultsByFrameIndexAndByFileName) {
  const Result<CocoDetections> read = Read(R"([
    {"image_id": 1, "category_id": 62, "bbox": [1, 2, 30, 20], "score": 0.5},
    {"image_id": "a", "category_name": "couch", "bbox": [1, 2, 300, 20]},
    {"image_id": "c.png", "category_name": "chair", "bbox": [1, 2, 3, 4], "score": 0.9}])");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->detections.size(), 3U);
  EXPECT_EQ(read->detections[0].frame, FrameIdx{0});
  EXPECT_EQ(read->detections[0].class_name, "sofa");
  EXPECT_EQ(read->detections[0].score, 1.0);
  EXPECT_EQ(read->detections[0].box_px.u_max, 63.0) << "clipped to the image";
  EXPECT_EQ(read->detections[1].class_name, "chair");
  EXPECT_EQ(read->detections[1].source, DetectionSource::kFile);
  EXPECT_EQ(read->detections[2].frame, FrameIdx{2});
}

TEST(CocoFile, ReadsDatasetsWithTheirOwnIdsAndMasks) {
  const Mask mask = SampleMask(64, 48);
  const Result<CocoDetections> read = Read(R"({
    "images": [{"id": 77, "file_name": "some/where/b.jpg"}],
    "categories": [{"id": 3, "name": "dining table"}],
    "annotations": [{"id": 1, "image_id": 77, "category_id": 3, "bbox": [0, 0, 20, 20],
                     "segmentation": {"size": [48, 64], "counts": ")" +
                                           EncodeRle(mask) + R"("}}]})");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->detections.size(), 1U);
  EXPECT_EQ(read->detections[0].frame, FrameIdx{1});
  EXPECT_EQ(read->detections[0].class_name, "table");
  EXPECT_EQ(read->detections[0].mask.Unpacked(), mask);
}

TEST(CocoFile, LeavesBadEntriesOutAndCountsThem) {
  const Result<CocoDetections> read = Read(R"([
    {"image_id": 9, "category_id": 62, "bbox": [1, 2, 30, 20]},
    {"image_id": 0, "category_id": 18, "bbox": [1, 2, 30, 20]},
    {"image_id": 0, "category_id": 62, "bbox": [100, 100, 30, 20]},
    {"image_id": 0, "category_id": 62, "bbox": [1, 2, -30, 20]},
    {"image_id": 0, "category_id": 62, "bbox": [1, 2, 1e300, 20]},
    {"image_id": 0, "category_id": 62, "bbox": "all"},
    {"image_id": 0, "category_id": 62},
    {"image_id": 0, "category_id": 62, "bbox": [1, 2, 30, 20], "score": 7},
    42,
    {"image_id": 0, "category_id": 62, "bbox": [1, 2, 30, 20], "segmentation": {"size": [1000000, 1000000], "counts": "6"}}])");
  ASSERT_TRUE(read.ok()) << read.error().message;
  const auto num_of = [&](CocoFault fault) { return read->losses.Of(fault).num_entries; };
  EXPECT_EQ(read->losses.num_entries, 10);
  EXPECT_EQ(read->losses.num_left_out(), 9);
  EXPECT_EQ(num_of(CocoFault::kUnknownImage), 1);
  EXPECT_EQ(num_of(CocoFault::kNamelessCategory), 1);
  EXPECT_EQ(num_of(CocoFault::kUnusableBox), 5);
  EXPECT_EQ(num_of(CocoFault::kUnusableScore), 1);
  EXPECT_EQ(num_of(CocoFault::kNoObject), 1);
  EXPECT_EQ(read->losses.num_unusable_masks, 1);
  ASSERT_EQ(read->detections.size(), 1U) << "a mask of another size leaves the box in force";
  EXPECT_TRUE(read->detections[0].mask.empty());
  EXPECT_THAT(read->warnings[0], HasSubstr("[0]"));
}

// What is told is the fault that the file has, and no other's remedy.
TEST(CocoFile, SaysWhyNoneFits) {
  const auto why = [](const std::string& fields) {
    const Result<CocoDetections> read = Read("[{" + fields + "}]");
    EXPECT_TRUE(read.ok() && read->detections.empty()) << fields;
    return read.ok() ? WhyNoneFits(read->losses) : std::string();
  };
  const std::string image = R"("image_id": 0, )";
  const std::string box = R"("bbox": [1, 2, 30, 20], )";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {box + R"("category_id": 62, "image_id": 9)", "image_id must be"},
      {image + box + R"("category_id": 2)", "category_id 2, which has no name"},
      {image + box + R"("score": 1)", "neither a category_name nor a category_id"},
      {image + box + R"("category_name": "zz")", "\"zz\""},
      {image + box + R"("category_name": "zz")", "`labels` of a class in classes.yaml"},
      {image + R"("category_id": 62)", "bbox must be"},
      {image + box + R"("category_id": 62, "score": 9)", "score must lie in [0, 1]"}};
  for (const auto& [fields, remedy] : cases) {
    const std::string told = why(fields);
    EXPECT_THAT(told, HasSubstr("1 of 1)"));
    EXPECT_THAT(told, HasSubstr(remedy));
    EXPECT_EQ(told.find("image_id must be") == std::string::npos, remedy != "image_id must be")
        << told;
  }
}

TEST(CocoFile, TellsHowManyFaultsItDoesNotList) {
  std::string text = "[7";
  for (int k = 1; k < 164; ++k) text += ", 7";
  const Result<CocoDetections> read = Read(text + "]");
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_GT(read->warnings.size(), 1U);
  EXPECT_THAT(read->warnings.back(),
              HasSubstr(fmt::format("and {} more", 164 - (read->warnings.size() - 1))));
  EXPECT_THAT(
      LossesAbove(0, read->losses),
      testing::ElementsAre(HasSubstr("164 of 164 entries are left out (164 are no objects")));
}

// Of `num` entries with a mask each, so many that are left out and so many whose mask is unusable.
CocoLosses LossesOf(int num, int num_left_out, int num_unusable_masks) {
  std::string text = "[";
  for (int k = 0; k < num; ++k) {
    text += fmt::format(
        R"({}{{"image_id": 1, "category_id": 62, "bbox": [1, 2, 30, 20], "score": {},
               "segmentation": {{"size": [48, 64], "counts": {}}}}})",
        k == 0 ? "" : ",",
        k < num_left_out ? 9 : 1,
        k < num_left_out + num_unusable_masks ? "[3072]" : "[0, 3072]");
  }
  const Result<CocoDetections> read = Read(text + "]");
  EXPECT_TRUE(read.ok()) << read.error().message;
  return read.ok() ? read->losses : CocoLosses();
}

TEST(CocoLosses, AreToldAboveAShare) {
  EXPECT_THAT(LossesAbove(0, LossesOf(4, 0, 0)), testing::IsEmpty());
  EXPECT_THAT(LossesAbove(0, LossesOf(0, 0, 0)), testing::IsEmpty());
  EXPECT_THAT(LossesAbove(0, LossesOf(6, 1, 2)),
              testing::ElementsAre(HasSubstr("1 of 6 entries"), HasSubstr("2 of 5 masks")));
  EXPECT_THAT(LossesAbove(0.5, LossesOf(4, 2, 1)), testing::IsEmpty()) << "half is not more";
  EXPECT_THAT(LossesAbove(0.5, LossesOf(4, 3, 0)),
              testing::ElementsAre(HasSubstr("3 have a score outside")));
  EXPECT_THAT(LossesAbove(0.5, LossesOf(6, 3, 2)), testing::ElementsAre(HasSubstr("2 of 3 masks")));
}

TEST(CocoFile, NoEntriesAreAResult) {
  for (const char* text : {"[]", R"({"annotations": []})"}) {
    const Result<CocoDetections> read = Read(text);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->losses.num_entries, 0);
    EXPECT_THAT(read->warnings, testing::IsEmpty());
  }
}

// Images of 64 x 48 in a capture whose colour has the size given.
CocoDetections ReadScaled(const std::string& text, const PictureSize& colour) {
  const Result<CocoDetections> read = ReadCocoFile([&] { return Result<TextSource>(text); },
                                                   "boxes.json",
                                                   Images(),
                                                   class_table::DefaultClassTable(),
                                                   colour);
  EXPECT_TRUE(read.ok()) << read.error().message;
  return read.ok() ? *read : CocoDetections();
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '\\' ? "\\\\" : std::string(1, c);
  return quoted + "\"";
}

std::string Dataset(const std::string& size, const std::string& more = "") {
  return R"({"images": [{"id": 77, "file_name": "b.jpg")" + size + R"(}],
    "annotations": [{"image_id": 77, "category_id": 62, "bbox": [20, 8, 40, 24])" +
         more + "}]}";
}

TEST(CocoFile, ScalesBoxesFromTheImagesSizeToTheFrames) {
  // The centre of pixel 20 lies 20.5 pixels from the image's side: 10.25 of those of the frame.
  const Box2 halved{9.75, 3.75, 29.75, 15.75};
  const Box2 untouched{20, 8, 60, 32};
  const auto box = [](const std::string& text, const PictureSize& colour) {
    const CocoDetections read = ReadScaled(text, colour);
    EXPECT_EQ(read.detections.size(), 1U) << text;
    EXPECT_THAT(read.warnings, testing::IsEmpty()) << text;
    return read.detections.empty() ? Box2() : read.detections[0].box_px;
  };
  const std::string stated = Dataset(R"(, "width": 128, "height": 96)");
  EXPECT_EQ(box(stated, {}), halved);
  EXPECT_EQ(box(stated, {256, 192}), halved) << "what is stated wins";
  EXPECT_EQ(box(Dataset(R"(, "width": 64, "height": 48)"), {128, 96}), untouched);
  EXPECT_EQ(box(Dataset(""), {128, 96}), halved);
  EXPECT_EQ(box(Dataset(""), {64, 48}), untouched);
  EXPECT_EQ(box(Dataset(""), {}), untouched);
  for (const char* unusable : {R"(, "width": 0, "height": 0)",
                               R"(, "width": 128)",
                               R"(, "width": -128, "height": -96)",
                               R"(, "width": 63.5, "height": 48)",
                               R"(, "width": 1e300, "height": 48)",
                               R"(, "width": "128", "height": null)"}) {
    EXPECT_EQ(box(Dataset(unusable), {128, 96}), halved) << unusable;
  }
  // Results without a table, and a table that an entry passes by.
  const std::string entry = R"({"image_id": "b", "category_id": 62, "bbox": [20, 8, 40, 24]})";
  EXPECT_EQ(box("[" + entry + "]", {128, 96}), halved);
  EXPECT_EQ(box(R"({"images": [{"id": 7, "file_name": "b.png", "width": 128, "height": 96}],
                    "annotations": [)" +
                    entry + "]}",
                {}),
            halved);
}

TEST(CocoFile, ReducesMasksToTheFrame) {
  Mask large(128, 96);
  for (int v = 10; v < 30; ++v) {
    for (int u = 40; u < 90; ++u) large(u, v) = 1;
  }
  Mask small(64, 48);
  for (int v = 5; v < 15; ++v) {
    for (int u = 20; u < 45; ++u) small(u, v) = 1;
  }
  const auto with_mask = [](const Mask& mask, const std::string& size) {
    return Dataset(size,
                   fmt::format(R"(, "segmentation": {{"size": [{}, {}], "counts": {}}})",
                               mask.height(),
                               mask.width(),
                               Quoted(EncodeRle(mask))));
  };
  const std::string stated = R"(, "width": 128, "height": 96)";
  const CocoDetections reduced = ReadScaled(with_mask(large, stated), {});
  ASSERT_EQ(reduced.detections.size(), 1U);
  EXPECT_EQ(reduced.detections[0].mask.Unpacked(), small);
  const CocoDetections of_another = ReadScaled(with_mask(small, stated), {});
  ASSERT_EQ(of_another.detections.size(), 1U);
  EXPECT_TRUE(of_another.detections[0].mask.empty());
  EXPECT_THAT(of_another.warnings, testing::ElementsAre(HasSubstr("image's size 128 x 96")));
  // Where nothing is stated, a mask of the frame's size says that the box is of the frame, too.
  const CocoDetections of_frame = ReadScaled(with_mask(small, ""), {128, 96});
  ASSERT_EQ(of_frame.detections.size(), 1U);
  EXPECT_EQ(of_frame.detections[0].mask.Unpacked(), small);
  EXPECT_EQ(of_frame.detections[0].box_px, (Box2{20, 8, 60, 32}));
}

TEST(CocoFile, TellsOnceWhenWidthAndHeightScaleDifferently) {
  std::string entries;
  for (int n = 0; n < 15; ++n) entries += R"({"image_id": 9, "category_id": 62, "bbox": "x"}, )";
  const std::string entry = R"({"image_id": 1, "category_id": 62, "bbox": [20, 8, 40, 24]})";
  const CocoDetections read = ReadScaled("[" + entries + entry + ", " + entry + "]", {1280, 720});
  EXPECT_EQ(read.detections.size(), 2U);
  EXPECT_THAT(
      read.warnings,
      testing::Contains(
          testing::AllOf(HasSubstr("rgb/b.png"), HasSubstr("1280 x 720"), HasSubstr("64 x 48")))
          .Times(1));
  // Rows that fill no block when colour is reduced are no reason.
  EXPECT_THAT(ReadScaled("[" + entry + "]", {129, 97}).warnings, testing::IsEmpty());
}

TEST(CocoFile, HostileSizesTakeNoMemory) {
  const CocoDetections read = ReadScaled(
      R"({"images": [{"id": 1, "file_name": "a.png", "width": 65536, "height": 65536}],
          "annotations": [{"image_id": 1, "category_id": 62, "bbox": [0, 0, 60000, 60000],
                           "segmentation": {"size": [65536, 65536], "counts": "6"}}]})",
      {});
  ASSERT_THAT(read.warnings, testing::ElementsAre(HasSubstr("scale"), HasSubstr("out of range")));
}

TEST(Rle, ResizesAtPixelCentres) {
  const Mask mask = SampleMask(64, 48);
  const Result<Mask> same = DecodeRleResized(EncodeRle(mask), 64, 48, 64, 48);
  ASSERT_TRUE(same.ok()) << same.error().message;
  EXPECT_EQ(*same, mask);
  for (const auto& [width, height] : {std::pair(32, 24), std::pair(21, 16), std::pair(128, 100)}) {
    const Result<Mask> resized = DecodeRleResized(EncodeRle(mask), 64, 48, width, height);
    ASSERT_TRUE(resized.ok()) << resized.error().message;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const int from_u = static_cast<int>((u + 0.5) * 64 / width);
        const int from_v = static_cast<int>((v + 0.5) * 48 / height);
        ASSERT_EQ((*resized)(u, v), mask(from_u, from_v)) << u << " " << v;
      }
    }
  }
  EXPECT_FALSE(DecodeRleResized("6", 4, 2, 2, 1).ok()) << "too short";
  EXPECT_FALSE(DecodeRleResized("6", 1 << 20, 1 << 20, 2, 1).ok());
}

TEST(CocoFile, RefusesWhatIsNoCoco) {
  for (const char* text :
       {"", "7", "\"boxes\"", "{\"images\": []}", "{\"annotations\": 3}", "[1, 2"}) {
    EXPECT_FALSE(Read(text).ok()) << text;
  }
}

TEST(ClassTable, ReadsBack) {
  const ClassTable table = class_table::DefaultClassTable();
  const Result<ClassTable> read =
      class_table::DecodeClassTable(class_table::EncodeClassTable(table), "classes.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(class_table::EncodeClassTable(*read), class_table::EncodeClassTable(table));
}

TEST(ClassTable, TellsAllFaultsWithTheirLines) {
  const Result<ClassTable> read = class_table::DecodeClassTable(
      "version: 1\n"
      "classes:\n"
      "  - name: chair\n"
      "    labels: [chair]\n"
      "    size_m: [2, 1]\n"
      "  - name: Chair\n"
      "    labels: [chair]\n"
      "    sice_m: [1, 2]\n"
      "    colour: [1, 2, 300]\n",
      "c.yaml");
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(read.error().message,
              testing::AllOf(HasSubstr("c.yaml:5"),
                             HasSubstr("sice_m"),
                             HasSubstr("c.yaml:9"),
                             HasSubstr("\"Chair\""),
                             HasSubstr("belongs to another class")));
}

}  // namespace
}  // namespace deepslam::artifact
