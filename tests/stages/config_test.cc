// The configuration as users see it: files equal the code, and every option counts.
#include <gmock/gmock.h>

#include "deepslam/artifact/class_table_yaml.h"
#include "deepslam/pipeline/config.h"
#include "deepslam/stages/config.h"
#include "deepslam/stages/data_folder.h"
#include "deepslam/stages/plan.h"
#include "deepslam/stages/verdict.h"
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
  EXPECT_EQ(config.select.mode, "greedy");
}

TEST(ClassesConfig, FileEqualsTheCode) {
  EXPECT_EQ(ReadText(Configs() / "classes.yaml"),
            artifact::EncodeClassTable(artifact::DefaultClassTable()))
      << "run `deepslam config classes > configs/classes.yaml`";
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
  changed.optimize.lambda_ground *= 2;
  // Loops by appearance are put through the graph as well.
  EXPECT_EQ(StagesThatDiffer({}, changed), (std::set<std::string>{"loops", "optimize"}));
  changed = {};
  changed.appearance.min_inliers += 1;
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

OptimizedMap MapWithFrames(int num_tracked, int num_lost) {
  OptimizedMap map;
  for (int i = 0; i < num_tracked + num_lost; ++i) {
    map.frames.push_back({FrameIdx{i},
                          i / 30.0,
                          {},
                          i < num_tracked ? TrackingStatus::kTracked : TrackingStatus::kLost,
                          FrameIdx{0},
                          0,
                          1});
  }
  map.keyframes = {FrameIdx{0}, FrameIdx{10}, FrameIdx{20}};
  map.has_ground = true;
  map.summary.converged = true;
  MapObject object;
  object.id = ObjectId{0};
  object.class_name = "chair";
  object.confidence = 0.9;
  map.map.objects = {object};
  return map;
}

// A walk at one pace; from `jump_at` on, the camera stands `jump_m` further along.
OptimizedMap MapOfAWalk(std::size_t jump_at, double jump_m) {
  OptimizedMap map = MapWithFrames(100, 0);
  for (std::size_t k = 0; k < map.frames.size(); ++k)
    map.frames[k].world_from_camera.translation_m.x() =
        0.02 * static_cast<double>(k) + (k >= jump_at ? jump_m : 0);
  return map;
}

TEST(Verdict, NamesTheFrameAtWhichTheCameraJumps) {
  EXPECT_EQ(JudgeRun(MapOfAWalk(40, 0), {}).verdict, Verdict::kGood);
  EXPECT_EQ(JudgeRun(MapOfAWalk(40, 0.1), {}).verdict, Verdict::kGood);
  const RunVerdict jumped = JudgeRun(MapOfAWalk(40, 0.5), {});
  EXPECT_EQ(jumped.verdict, Verdict::kDoubtful);
  EXPECT_THAT(jumped.reasons, testing::ElementsAre(HasSubstr("0.52 m at frame 40;")));
  // Keyframes far apart, as sparse captures have them, are a pace of their own.
  OptimizedMap sparse = MapOfAWalk(40, 0);
  for (TrackedFrame& frame : sparse.frames) frame.world_from_camera.translation_m *= 20;
  EXPECT_EQ(JudgeRun(sparse, {}).verdict, Verdict::kGood);
}

// Keyframes every ten frames; tracking starts anew at each of `starts`, as its lost keyframes.
struct BrokenWalk {
  OptimizedMap map = MapOfAWalk(0, 0);
  std::vector<KeyframeJoin> joins;

  explicit BrokenWalk(const std::set<int>& starts) {
    map.keyframes.clear();
    for (int k = 0; k < 100; k += 10) {
      map.keyframes.push_back(FrameIdx{k});
      if (k == 0) continue;
      joins.push_back(Join(k - 10, k));
      joins.back().composed = starts.contains(k);
      if (starts.contains(k))
        map.frames[static_cast<std::size_t>(k)].status = TrackingStatus::kLost;
    }
  }

  static KeyframeJoin Join(int i, int j) { return {FrameIdx{i}, FrameIdx{j}}; }
};

TEST(Verdict, NamesThePartsWhosePlaceNobodyMeasured) {
  BrokenWalk walk({60});
  EXPECT_EQ(JudgeRun(BrokenWalk({}).map, walk.joins).verdict, Verdict::kGood)
      << "a chain of tracked frames is measured";
  const RunVerdict two = JudgeRun(walk.map, walk.joins);
  EXPECT_EQ(two.verdict, Verdict::kBad);
  EXPECT_THAT(two.reasons,
              testing::ElementsAre(testing::AllOf(HasSubstr("at frame 60"),
                                                  HasSubstr("frames 60 to 99"),
                                                  HasSubstr("not measured"),
                                                  HasSubstr("40 %"),
                                                  HasSubstr("overlap"))));
  // A loop, or keyframes measured again across the loss.
  walk.joins.push_back(BrokenWalk::Join(20, 80));
  EXPECT_EQ(JudgeRun(walk.map, walk.joins).verdict, Verdict::kGood);
}

TEST(Verdict, TheSmallerPartIsAdriftWhereverItStands) {
  const BrokenWalk first({10});
  const RunVerdict early = JudgeRun(first.map, first.joins);
  EXPECT_EQ(early.verdict, Verdict::kDoubtful);
  EXPECT_THAT(
      early.reasons,
      testing::ElementsAre(testing::AllOf(HasSubstr("at frame 10"), HasSubstr("frames 0 to 9 "))));
  // The last part has met the first again, so that what lies between alone hangs in the air.
  BrokenWalk between({30, 40});
  EXPECT_THAT(JudgeRun(between.map, between.joins).reasons,
              testing::ElementsAre(HasSubstr("1 more such part")));
  between.joins.push_back(BrokenWalk::Join(10, 70));
  const RunVerdict middle = JudgeRun(between.map, between.joins);
  EXPECT_EQ(middle.verdict, Verdict::kDoubtful);
  EXPECT_THAT(middle.reasons,
              testing::ElementsAre(testing::AllOf(
                  HasSubstr("at frame 30"), HasSubstr("frames 30 to 39 "), HasSubstr("10 %"))));
}

TEST(Verdict, AFrameThatIsFoundAgainDoesNotVouchForWhatIsBetween) {
  // Tracking starts anew at 30 and meets keyframe 20 again at 40: tracked, with a measured edge to
  // 20 and a composed one to its neighbour.
  BrokenWalk found({30, 40});
  found.map.frames[40].status = TrackingStatus::kTracked;
  found.joins.push_back(BrokenWalk::Join(20, 40));
  EXPECT_THAT(JudgeRun(found.map, found.joins).reasons,
              testing::ElementsAre(HasSubstr("frames 30 to 39 ")));
}

TEST(Verdict, SeesJumpsWhereTheClockWasSetBack) {
  const auto set_back = [](OptimizedMap map) {
    for (std::size_t k = 40; k < map.frames.size(); ++k) map.frames[k].time_s -= 0.7;
    return map;
  };
  EXPECT_EQ(JudgeRun(set_back(MapOfAWalk(40, 0)), {}).verdict, Verdict::kGood);
  EXPECT_THAT(JudgeRun(set_back(MapOfAWalk(40, 0.5)), {}).reasons,
              testing::ElementsAre(HasSubstr("0.52 m at frame 40;")));
}

TEST(Verdict, FollowsWhatWentWrong) {
  EXPECT_EQ(JudgeRun(MapWithFrames(100, 0), {}).verdict, Verdict::kGood);
  EXPECT_EQ(JudgeRun(MapWithFrames(90, 10), {}).verdict, Verdict::kDoubtful);
  EXPECT_EQ(JudgeRun(MapWithFrames(40, 60), {}).verdict, Verdict::kBad);
  OptimizedMap standing = MapWithFrames(100, 0);
  standing.keyframes = {FrameIdx{0}};
  EXPECT_EQ(JudgeRun(standing, {}).verdict, Verdict::kDoubtful);
  OptimizedMap map = MapWithFrames(100, 0);
  map.has_ground = false;
  map.map.objects[0].confidence = 0.1;
  const RunVerdict doubtful = JudgeRun(map, {});
  EXPECT_EQ(doubtful.verdict, Verdict::kDoubtful);
  EXPECT_THAT(doubtful.reasons, testing::ElementsAre(HasSubstr("ground"), HasSubstr("chair_00")));
  map.map.objects.clear();
  EXPECT_EQ(JudgeRun(map, {}).verdict, Verdict::kBad);
}

TEST(Verdict, BeginsWithWhatIsDoubtedOfTheCapture) {
  const std::vector<std::string> doubts = {"half of the depth is nearer than 0.20 m"};
  const RunVerdict doubted = JudgeRun(MapWithFrames(100, 0), {}, doubts);
  EXPECT_EQ(doubted.verdict, Verdict::kDoubtful);
  EXPECT_THAT(doubted.reasons, testing::ElementsAreArray(doubts));
  const RunVerdict lost = JudgeRun(MapWithFrames(40, 60), {}, doubts);
  EXPECT_EQ(lost.verdict, Verdict::kBad);
  EXPECT_THAT(lost.reasons, testing::ElementsAre(doubts[0], HasSubstr("could not be tracked")));
}

}  // namespace
}  // namespace deepslam::stages
