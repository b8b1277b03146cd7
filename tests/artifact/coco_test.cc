#include <gmock/gmock.h>

#include "artifact/sample_values.h"
#include "deepslam/artifact/class_table_yaml.h"
#include "deepslam/artifact/coco_file.h"
#include "deepslam/artifact/rle.h"

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
  return ReadCocoFile(text, "boxes.json", Images(), DefaultClassTable());
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
  EXPECT_EQ(read->num_unknown_image, 1);
  EXPECT_EQ(read->num_unknown_class, 1);
  EXPECT_EQ(read->num_unusable, 8);
  ASSERT_EQ(read->detections.size(), 1U) << "a mask of another size leaves the box in force";
  EXPECT_TRUE(read->detections[0].mask.empty());
  EXPECT_THAT(read->warnings[0], HasSubstr("[0]"));
}

TEST(CocoFile, RefusesWhatIsNoCoco) {
  for (const char* text :
       {"", "7", "\"boxes\"", "{\"images\": []}", "{\"annotations\": 3}", "[1, 2"}) {
    EXPECT_FALSE(Read(text).ok()) << text;
  }
}

TEST(ClassTable, ReadsBack) {
  const ClassTable table = DefaultClassTable();
  const Result<ClassTable> read = DecodeClassTable(EncodeClassTable(table), "classes.yaml");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(EncodeClassTable(*read), EncodeClassTable(table));
}

TEST(ClassTable, TellsAllFaultsWithTheirLines) {
  const Result<ClassTable> read = DecodeClassTable(
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
                             HasSubstr("two classes")));
}

}  // namespace
}  // namespace deepslam::artifact
