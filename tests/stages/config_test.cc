// The configuration as users see it: files equal the code, and every option counts.
#include <gmock/gmock.h>

#include "deepslam/class_table/class_table_yaml.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/mesh_options.h"
#include "deepslam/stages/plan.h"
#include "support/temp_dir.h"

namespace deepslam::stages {
namespace {

using testing::HasSubstr;
using testing_support::ReadText;
using testing_support::TempDir;
using testing_support::WriteText;

std::filesystem::path Configs() { return std::filesystem::path(DEEPSLAM_SOURCE_DIR) / "configs"; }

std::vector<pipeline::Stage> PlanFor(const Config& config) {
  return MakePlan(std::make_shared<const RunInputs>(RunInputs{config, {}, nullptr, {}}));
}

// Stages whose options differ.
std::set<std::string> StagesThatDiffer(const Config& a, const Config& b) {
  const std::vector<pipeline::Stage> plan_a = PlanFor(a);
  const std::vector<pipeline::Stage> plan_b = PlanFor(b);
  std::set<std::string> names;
  for (std::size_t i = 0; i < plan_a.size(); ++i) {
    if (plan_a[i].options != plan_b[i].options) names.insert(plan_a[i].name);
  }
  return names;
}

TEST(DefaultConfig, FileEqualsTheCode) {
  Config config;
  EXPECT_EQ(ReadText(Configs() / "default.yaml"), pipeline::DumpConfig(Sections(config)))
      << "run `deepslam config dump > configs/default.yaml`";
}

TEST(DefaultConfig, DefaultsLieInTheirOwnRanges) {
  Config config;
  const std::vector<pipeline::OptionSection> sections = Sections(config);
  const Status status = pipeline::ApplyYaml(sections, pipeline::DumpConfig(sections), "dump");
  EXPECT_TRUE(status.ok()) << status.error().message;
}

TEST(DefaultConfig, NamesAreUniqueAndExplained) {
  Config config;
  std::set<std::string> names;
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(Sections(config))) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name << " stands twice";
    EXPECT_FALSE(entry.help.empty()) << entry.name;
  }
}

TEST(PaperConfig, IsAnOverlayWithoutFaults) {
  Config config;
  const std::string paper = ReadText(Configs() / "paper.yaml");
  ASSERT_FALSE(paper.empty());
  const Status status = pipeline::ApplyYaml(Sections(config), paper, "paper.yaml");
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(config.track.reference, "previous");
  EXPECT_EQ(config.detect_stage.frames, "all");
  EXPECT_EQ(config.associate_stage.method, "votes");
  EXPECT_EQ(config.select.mode, "greedy");
}

TEST(ClassesConfig, FileEqualsTheCode) {
  EXPECT_EQ(ReadText(Configs() / "classes.yaml"),
            class_table::EncodeClassTable(class_table::DefaultClassTable()))
      << "run `deepslam config classes > configs/classes.yaml`";
}

TEST(ClassesConfig, OptionsThatListedClassesSayWhereTheirTraitsStandNow) {
  Config config;
  const Status status = pipeline::ApplyYaml(Sections(config),
                                            "segment:\n  level_top_classes: \"table, desk\"\n"
                                            "loops:\n  yaw_free_classes: table\n"
                                            "propose:\n  measured:\n    solid_classes: bed\n",
                                            "old.yaml");
  ASSERT_FALSE(status.ok());
  for (const char* expected :
       {"old.yaml:2: segment.level_top_classes is no option any more: `support_plane: true`",
        "old.yaml:4: loops.yaw_free_classes is no option any more: `yaw_free: true`",
        "old.yaml:7: propose.measured.solid_classes is no option any more: `solid_inside: true`",
        "classes.file"})
    EXPECT_THAT(status.error().message, HasSubstr(expected));
}

TEST(RetiredOptions, AreRefusedWithTheValueThatHoldsOrTheNewName) {
  Config config;
  const Status status = pipeline::ApplyYaml(Sections(config),
                                            "register:\n  num_azimuths: 8\n"
                                            "select:\n  min_size: 0.2\n"
                                            "optimize:\n  use_ground: false\n",
                                            "old.yaml");
  ASSERT_FALSE(status.ok());
  for (const char* expected :
       {"old.yaml:2: register.num_azimuths is no option any more: its value is fixed at 8; remove",
        "old.yaml:4: select.min_size is no option any more: it is called select.min_size_m",
        "old.yaml:6: optimize.use_ground is no option any more: its value is fixed at true"})
    EXPECT_THAT(status.error().message, HasSubstr(expected));
}

TEST(RetiredOptions, AreNoOptions) {
  class Names final : public OptionsVisitor {
   public:
    explicit Names(std::string section) : section_(std::move(section)) {}
    void Field(std::string_view, double&, Range, std::string_view, std::string_view) override {}
    void Field(std::string_view, int&, Range, std::string_view, std::string_view) override {}
    void Field(std::string_view, bool&, std::string_view) override {}
    void Field(std::string_view, std::string&, std::string_view) override {}
    void Choice(std::string_view,
                std::string&,
                std::span<const std::string_view>,
                std::string_view) override {}
    void Retired(std::string_view name, std::string_view) override {
      EXPECT_TRUE(names.insert(section_ + "." + std::string(name)).second) << name << " twice";
    }
    std::set<std::string> names;

   private:
    std::string section_;
  };
  Config config;
  const std::vector<pipeline::OptionSection> sections = Sections(config);
  std::set<std::string> retired;
  for (const pipeline::OptionSection& section : sections) {
    Names names(section.name);
    section.describe(names);
    retired.merge(names.names);
  }
  EXPECT_GT(retired.size(), 100U);
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(sections))
    EXPECT_FALSE(retired.contains(entry.name)) << entry.name;
}

// What no stage has in its key may change without anything being made again.
TEST(Keys, HoldEveryOptionButFiles) {
  std::set<std::string> in_keys;
  for (const pipeline::Stage& stage :
       MakePlan(std::make_shared<const RunInputs>(RunInputs{{}, {}, nullptr, {}}))) {
    for (const auto& [name, value] : stage.options) in_keys.insert(name);
  }
  Config config;
  std::set<std::string> in_none;
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(Sections(config))) {
    if (!in_keys.contains(entry.name)) in_none.insert(entry.name);
  }
  // The content of these files is hashed.
  const std::set<std::string> files = {
      "classes.file", "detect.file", "detect.weights", "propose.library", "propose.priors"};
  EXPECT_EQ(in_none, files);
}

// Every stage that asks for a trait runs again when one changes.
TEST(Keys, AClassesTraitChangesTheStagesThatLookAtIt) {
  const auto classes_in_keys = [](const ClassTable& classes) {
    std::map<std::string, std::string> hashes;
    for (const pipeline::Stage& stage :
         MakePlan(std::make_shared<const RunInputs>(RunInputs{{}, classes, nullptr, {}}))) {
      const auto inputs = stage.external_inputs();
      if (inputs.ok() && inputs->contains("classes")) hashes[stage.name] = inputs->at("classes");
    }
    return hashes;
  };
  const ClassTable classes = class_table::DefaultClassTable();
  ClassTable changed = classes;
  changed.classes.front().traits.yaw_free = !changed.classes.front().traits.yaw_free;
  for (const char* stage : {"segment", "loops", "mesh", "export", "report"}) {
    const auto before = classes_in_keys(classes);
    ASSERT_TRUE(before.contains(stage)) << stage;
    EXPECT_NE(before.at(stage), classes_in_keys(changed).at(stage)) << stage;
  }
}

TEST(Keys, EveryOptionBelongsToAStage) {
  std::set<std::string> in_keys;
  for (const pipeline::Stage& stage : PlanFor({})) {
    for (const auto& [name, value] : stage.options) in_keys.insert(name);
  }
  const std::set<std::string> paths = {
      "classes.file", "detect.weights", "detect.file", "propose.library", "propose.priors"};
  Config config;
  for (const pipeline::OptionEntry& entry : pipeline::ListOptions(Sections(config))) {
    EXPECT_NE(in_keys.contains(entry.name), paths.contains(entry.name)) << entry.name;
  }
}

TEST(Keys, AnOptionChangesItsOwnStagesOnly) {
  Config changed;
  changed.optimize.loss_rounds += 1;
  // Loops by appearance are put through the graph as well.
  EXPECT_EQ(StagesThatDiffer({}, changed), (std::set<std::string>{"loops", "optimize"}));
  changed = {};
  changed.appearance.max_keyframes += 1;
  EXPECT_EQ(StagesThatDiffer({}, changed), std::set<std::string>{"loops"});
  changed = {};
  changed.views.max_views += 1;
  EXPECT_EQ(StagesThatDiffer({}, changed),
            (std::set<std::string>{"propose", "register", "select", "loops", "mesh"}));
}

TEST(Keys, PlacesOnDiskDoNotCount) {
  Config changed;
  changed.detect_stage.weights = "/elsewhere/yolov8s.onnx";
  changed.propose_stage.library = "/elsewhere/library";
  changed.classes_file = "/elsewhere/classes.yaml";
  EXPECT_TRUE(StagesThatDiffer({}, changed).empty());
}

TEST(Plan, InputsStandBeforeTheirUsers) {
  std::set<std::string> seen;
  for (const pipeline::Stage& stage : PlanFor({})) {
    for (const std::string& input : stage.inputs)
      EXPECT_TRUE(seen.contains(input)) << stage.name << " reads " << input;
    seen.insert(stage.name);
  }
}

TEST(MeshOptions, OfTheMapAreThoseItsShapesWereMadeBy) {
  EXPECT_TRUE(NotedMeshOptions(Config()).empty());
  Config config;
  config.surface.iterations = 7;
  config.colour.segment_only = !config.colour.segment_only;  // no matter of shape
  CompactMap map;
  map.mesh_options = NotedMeshOptions(config);
  EXPECT_EQ(map.mesh_options.size(), 1U);
  const Result<mesh::ObjectMeshOptions> options = MeshOptionsOf(map);
  ASSERT_TRUE(options.ok()) << options.error().message;
  EXPECT_EQ(options->surface.iterations, 7);
  for (const char* wrong : {"mesh.surface.nonsense", "track.poses"}) {
    map.mesh_options = {{wrong, "1"}};
    const Result<mesh::ObjectMeshOptions> refused = MeshOptionsOf(map);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidInput);
    EXPECT_THAT(refused.error().message, HasSubstr(wrong));
  }
}

TEST(DataFolder, NamesTheRemedyForMissingWeightsAndLibrary) {
  const TempDir dir;
  const auto weights = FindWeights(dir.path(), "yolov8s");
  ASSERT_FALSE(weights.ok());
  EXPECT_EQ(weights.error().code, ErrorCode::kInvalidInput);
  EXPECT_THAT(weights.error().message,
              testing::AllOf(HasSubstr("scripts/setup.sh"), HasSubstr("deepslam doctor")));
  EXPECT_THAT(FindLibrary(dir.path(), "").error().message, HasSubstr("deepslam library build"));
  WriteText(dir.path() / "weights" / "own.onnx", "x");
  EXPECT_EQ(*FindWeights(dir.path(), "own"), dir.path() / "weights" / "own.onnx");
  EXPECT_EQ(*FindWeights("/nowhere", (dir.path() / "weights" / "own.onnx").string()),
            dir.path() / "weights" / "own.onnx");
}

TEST(DataFolder, TakesTheDetectorWithMasksAndElseTheOneOfBoxes) {
  const TempDir dir;
  EXPECT_THAT(FindWeights(dir.path(), "").error().message, HasSubstr("yolo11n-seg.onnx"));
  const auto boxes = dir.path() / "weights" / "yolov8s.onnx";
  WriteText(boxes, "x");
  EXPECT_EQ(*FindWeights(dir.path(), ""), boxes);
  EXPECT_FALSE(FindWeights(dir.path(), "yolo11n-seg").ok()) << "what is named is not replaced";
  const auto masks = dir.path() / "weights" / "yolo11n-seg.onnx";
  WriteText(masks, "x");
  EXPECT_EQ(*FindWeights(dir.path(), ""), masks);
}

}  // namespace
}  // namespace deepslam::stages
