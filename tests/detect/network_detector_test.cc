#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/detect/detect_frame.h"
#include "deepslam/detect/detector.h"
#include "deepslam/detect/yolo_heads.h"
#include "support/tiny_onnx.h"

namespace deepslam::detect {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing_support::TinyNetwork;
using testing_support::WriteOnnx;

constexpr int kCells64 = 64 + 16 + 4;

// One dining table in the middle of the input, whatever the image.
TinyNetwork TableNetwork() {
  TinyNetwork network;
  std::vector<float> head(6 * kCells64, 0.0F);
  const std::vector<float> column = {32, 32, 20, 10, 0.1F, 0.9F};
  for (std::size_t row = 0; row < 6; ++row) head[row * kCells64 + 3] = column[row];
  network.outputs = {{{1, 6, kCells64}, head}};
  network.metadata["names"] = "{0: 'chair', 1: 'dining table'}";
  return network;
}

void ExpectRefused(const std::string& bytes, const std::string& why) {
  const auto detector = LoadNetworkDetector(bytes, {});
  ASSERT_FALSE(detector.ok()) << why;
  EXPECT_EQ(detector.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(detector.error().message, HasSubstr(why));
}

TEST(LoadNetworkDetector, RunsANetworkFromItsBytes) {
  const auto detector = LoadNetworkDetector(WriteOnnx(TableNetwork()), {});
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  const auto found = (*detector)->Detect(ColourImage(128, 128));
  ASSERT_TRUE(found.ok());
  ASSERT_THAT(*found, SizeIs(1));
  EXPECT_EQ((*found)[0].label, "dining table");
  EXPECT_THAT((*detector)->labels(), testing::ElementsAre("chair", "dining table"));
  EXPECT_NEAR((*found)[0].score, 0.9, 1e-6);
  EXPECT_EQ((*found)[0].box_px, (Box2{43.5, 53.5, 83.5, 73.5}));
  const auto nothing = (*detector)->Detect(ColourImage());
  ASSERT_TRUE(nothing.ok());
  EXPECT_THAT(*nothing, IsEmpty());
}

TEST(LoadNetworkDetector, RefusesWhatIsNoNetwork) {
  ExpectRefused("", "empty");
  ExpectRefused("this is a text file", "19 bytes");
  ExpectRefused(std::string(1000, '\0'), "1000 bytes");
  const std::string whole = WriteOnnx(TableNetwork());
  ExpectRefused(whole.substr(0, whole.size() / 2), "ONNX");
}

TEST(LoadNetworkDetector, RefusesForeignNetworksAndSaysWhatTheyAre) {
  TinyNetwork network = TableNetwork();
  network.input_shape = {1, 10};
  ExpectRefused(WriteOnnx(network), "1x10");
  network.input_shape = {1, 3, 50, 50};
  ExpectRefused(WriteOnnx(network), "1x3x50x50");
  network.input_shape = {1, 3, 1 << 20, 1 << 20};
  ExpectRefused(WriteOnnx(network), "multiples of 32");
  network = TableNetwork();
  network.outputs = {{{1, 5}, {0, 0, 0, 0, 0}}};
  ExpectRefused(WriteOnnx(network), "1x5");
  network = TableNetwork();
  network.metadata.clear();
  ExpectRefused(WriteOnnx(network), "names");
  network.metadata["names"] = "{0: 'chair'}";
  ExpectRefused(WriteOnnx(network), "1x6x84");
}

TEST(LoadNetworkDetector, MeasuresOutputsThatAreLeftOpen) {
  TinyNetwork network = TableNetwork();
  network.outputs[0].stated_shape = {1, 6, -1};
  const auto detector = LoadNetworkDetector(WriteOnnx(network), {});
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  const auto found = (*detector)->Detect(ColourImage(64, 64));
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_THAT(*found, SizeIs(1));
}

TEST(LoadNetworkDetector, DoesNotTrustTheShapeThatAFileStates) {
  // As many values as are stated would reach far beyond those that come.
  TinyNetwork network = TableNetwork();
  network.input_shape = {1, 3, 640, 640};
  network.outputs[0].stated_shape = {1, 6, 8400};
  const auto detector = LoadNetworkDetector(WriteOnnx(network), {});
  if (!detector.ok()) return;
  const auto found = (*detector)->Detect(ColourImage(64, 64));
  ASSERT_FALSE(found.ok());
  EXPECT_THAT(found.error().message, HasSubstr("shapes"));
}

TEST(LoadNetworkDetector, FallsBackToCocoLabels) {
  TinyNetwork network;
  std::vector<float> head(84 * kCells64, 0.0F);
  const std::vector<float> box = {32, 32, 20, 10};
  for (std::size_t row = 0; row < 4; ++row) head[row * kCells64] = box[row];
  head[(4 + 56) * kCells64] = 0.8F;
  network.outputs = {{{1, 84, kCells64}, head}};
  const auto detector = LoadNetworkDetector(WriteOnnx(network), {});
  ASSERT_TRUE(detector.ok()) << detector.error().message;
  const auto found = (*detector)->Detect(ColourImage(64, 64));
  ASSERT_TRUE(found.ok());
  ASSERT_THAT(*found, SizeIs(1));
  EXPECT_EQ((*found)[0].label, "chair");
}

ClassTable SomeClasses() {
  ClassTable table;
  table.classes.resize(2);
  table.classes[0].name = "seat";
  table.classes[0].detector_labels = {"chair", "couch"};
  table.classes[1].name = "table";
  table.classes[1].detector_labels = {"dining table"};
  return table;
}

Frame EmptyFrame() {
  Frame frame;
  frame.idx = {7};
  frame.colour = ColourImage(200, 100);
  return frame;
}

TEST(MapDetections, MapsLabelsAndDropsDuplicates) {
  const Box2 box = {10, 10, 60, 60};
  const Box2 other = {120, 10, 190, 90};
  const std::vector<RawDetection> raw = {{"couch", 0.5, {12, 10, 60, 60}, {}},
                                         {"chair", 0.6, box, {}},
                                         {"dining table", 0.9, other, {}},
                                         {"chair", 0.8, {121, 10, 190, 90}, {}},
                                         {"person", 0.9, {70, 10, 110, 90}, {}},
                                         {"chair", 0.1, {70, 10, 110, 90}, {}}};
  const auto found = MapDetections(raw, EmptyFrame(), SomeClasses(), {});
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].class_name, "table");
  EXPECT_EQ(found[1].class_name, "seat");
  EXPECT_EQ(found[1].box_px, box);
  EXPECT_EQ(found[1].frame, FrameIdx{7});
  EXPECT_EQ(found[1].source, DetectionSource::kNetwork);
}

TEST(MapDetections, DropsBoxesThatMakeNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<RawDetection> raw = {{"chair", nan, {10, 10, 60, 60}, {}},
                                         {"chair", 0.9, {nan, 10, 60, 60}, {}},
                                         {"chair", 0.9, {-inf, 10, inf, 60}, {}},
                                         {"chair", 0.9, {60, 60, 10, 10}, {}},
                                         {"chair", 0.9, {500, 500, 600, 600}, {}},
                                         {"chair", 0.9, {10, 10, 13, 60}, {}}};
  EXPECT_THAT(MapDetections(raw, EmptyFrame(), SomeClasses(), {}), IsEmpty());
  Frame none;
  EXPECT_THAT(
      MapDetections(
          std::vector<RawDetection>{{"chair", 0.9, {10, 10, 60, 60}, {}}}, none, SomeClasses(), {}),
      IsEmpty());
}

std::vector<std::string> NamesNeverDetected(const ClassTable& classes) {
  std::vector<std::string> names;
  for (const ObjectClass* c :
       NeverDetected(classes, class_table::DefaultClassTable(), CocoLabels()))
    names.push_back(c->name);
  return names;
}

TEST(NeverDetected, AreClassesOfTheUsersNoneOfWhoseLabelsTheDetectorKnows) {
  ClassTable classes = class_table::DefaultClassTable();
  ASSERT_THAT(CocoLabels(), testing::Not(testing::Contains("lamp")));
  EXPECT_THAT(NamesNeverDetected(classes), IsEmpty()) << "the table delivered has a lamp";
  const auto add = [&](const char* name, std::vector<std::string> labels) {
    ObjectClass added;
    added.name = name;
    added.detector_labels = std::move(labels);
    classes.classes.push_back(added);
  };
  add("by depth", {});
  add("pet", {"hound", "dog"});
  EXPECT_THAT(NamesNeverDetected(classes), IsEmpty()) << "one known label is enough";
  add("monster", {"dragon", "Dog"});
  EXPECT_THAT(NamesNeverDetected(classes), testing::ElementsAre("monster"));
  for (ObjectClass& c : classes.classes) {
    if (c.name == "lamp") c.detector_labels = {"torchiere"};
  }
  EXPECT_THAT(NamesNeverDetected(classes), testing::ElementsAre("lamp", "monster"));
}

class FailingDetector final : public Detector {
 public:
  [[nodiscard]] std::vector<std::string> labels() const override { return {}; }
  [[nodiscard]] Result<std::vector<RawDetection>> Detect(const ColourImage&) const override {
    return Failed("out of memory");
  }
};

TEST(DetectFrame, PassesOnWhatTheDetectorSays) {
  const auto found = DetectFrame(FailingDetector(), EmptyFrame(), SomeClasses(), {});
  ASSERT_FALSE(found.ok());
  EXPECT_THAT(found.error().message, HasSubstr("out of memory"));
}

}  // namespace
}  // namespace deepslam::detect
