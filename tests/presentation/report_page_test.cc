#include "deepslam/presentation/report_page.h"

#include <algorithm>
#include <atomic>
#include <string>

#include <gmock/gmock.h>

#include "deepslam/report/report.h"
#include "presentation/room_with_box.h"

namespace deepslam::presentation {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class AskedToStop final : public Progress {
 public:
  void Report(std::size_t, std::size_t) override {}
  void Warn(std::string_view) override {}
  [[nodiscard]] bool StopRequested() const override { return true; }
};

// A cuboid where RoomWithBox() has its object, seen by the same cameras. Detection n is that of
// frame n; frame 4 shows a person.
class ReportOfABox : public testing::Test {
 protected:
  ReportOfABox()
      : source_({{0, {-0.5, -0.5, 0}, {0.5, 0.5, 1}}},
                testing_support::Orbit({0, 0, 0.5}, 2.5, 1.5, -20, 10, 5)) {
    sources_.run = SomeRun();
    sources_.finished = RoomWithBox();
    for (int n = 0; n < 5; ++n) {
      sources_.detected.push_back({FrameIdx{n}, n == 4});
      segments_.push_back(SegmentIn(FrameIdx{n}));
      sources_.segments.push_back(segments_.back());
      sources_.segments.back().mask = {};
    }
    const OptimizedMap& map = sources_.finished.map;
    sources_.trajectory.frames = map.frames;
    sources_.trajectory.keyframes = map.keyframes;
    ShapeCandidate candidate;
    candidate.id = map.map.objects[0].chosen;
    candidate.model = "fused_3";
    candidate.source = CandidateSource::kFused;
    sources_.proposals.candidates = {candidate};
    sources_.proposals.notes = {"class lamp has no prior"};
    sources_.verdict = {Verdict::kDoubtful, {"few keyframes"}};
    sources_.scene_glb = "glTF";
  }

  Segment SegmentIn(FrameIdx frame) const {
    const Image<int>& object = source_.View(frame).object;
    Mask mask(object.width(), object.height());
    Segment segment;
    segment.box_px = {1e9, 1e9, -1, -1};
    for (int v = 0; v < object.height(); ++v) {
      for (int u = 0; u < object.width(); ++u) {
        if (object(u, v) != 0) continue;
        mask(u, v) = 1;
        ++segment.num_points;
        segment.box_px = {std::min<double>(segment.box_px.u_min, u),
                          std::min<double>(segment.box_px.v_min, v),
                          std::max<double>(segment.box_px.u_max, u),
                          std::max<double>(segment.box_px.v_max, v)};
      }
    }
    segment.detection = DetectionId{frame.value};
    segment.frame = frame;
    segment.class_name = "cabinet";
    segment.score = 0.8;
    segment.mask = PixelMask(mask);
    segment.usable = true;
    return segment;
  }

  Result<ReportPage> Page(const Progress& progress = SilentProgress()) {
    const ReportAccess access{
        source_,
        [&](const std::set<DetectionId>& wanted) -> Result<std::vector<Segment>> {
          asked_for_ = wanted;
          if (fault_) return *fault_;
          std::vector<Segment> found;
          std::ranges::copy_if(segments_, std::back_inserter(found), [&](const Segment& segment) {
            return wanted.contains(segment.detection);
          });
          return found;
        },
        [&](const ShapeCandidate& candidate, bool) -> std::shared_ptr<const shape::ShapeModel> {
          if (candidate.model != "fused_3") return nullptr;
          return std::make_shared<const shape::ShapeModel>(CubeGrid());
        }};
    return MakeReportPage(sources_, access, OneClass(), progress);
  }

  testing_support::BoxWorldSource source_;
  ReportSources sources_;
  std::vector<Segment> segments_;
  std::set<DetectionId> asked_for_;
  std::optional<Error> fault_;
};

TEST_F(ReportOfABox, ShowsTheObjectWhereItWasMeasured) {
  const Result<ReportPage> page = Page();
  ASSERT_TRUE(page.ok()) << page.error().message;
  ASSERT_EQ(page->content.objects.size(), 1U);
  const report::ObjectRow& row = page->content.objects[0];
  EXPECT_EQ(row.name, "cabinet_03");
  EXPECT_EQ(row.colour, (Rgb8{10, 20, 30}));
  EXPECT_EQ(row.pictures.size(), 2U);  // of its two views
  ASSERT_GT(row.measured_world.size(), 100U);
  for (const Eigen::Vector3f& p : row.measured_world) {  // on the cuboid, by the true cameras
    EXPECT_LT(p.head<2>().cwiseAbs().maxCoeff(), 0.51F);
    EXPECT_GT(p.z(), -0.01F);
    EXPECT_LT(p.z(), 1.01F);
  }
  ASSERT_EQ(row.candidates.size(), 1U);
  EXPECT_TRUE(row.candidates[0].chosen);
  EXPECT_FALSE(row.candidates[0].thumbnail.bytes.empty());
  EXPECT_EQ(page->content.scene_pictures.size(), 2U);
  EXPECT_FALSE(page->thumbnail.bytes.empty());
  EXPECT_FALSE(page->content.photographs.empty());
}

TEST_F(ReportOfABox, SaysWhatTheStagesFound) {
  sources_.capture_warnings = {"one frame is missing"};
  sources_.corrections = {"object 7 was dropped"};
  const report::ReportContent content = Page()->content;
  EXPECT_EQ(content.title, "kitchen");
  EXPECT_EQ(content.verdict, "doubtful");
  EXPECT_THAT(content.verdict_reasons, ElementsAre("few keyframes"));
  EXPECT_THAT(content.warnings, ElementsAre("one frame is missing", "class lamp has no prior"));
  EXPECT_THAT(content.corrections, ElementsAre("object 7 was dropped"));
  EXPECT_EQ(content.scene_glb, "glTF");
  EXPECT_EQ(content.tracked_world_from_camera.size(), sources_.finished.map.frames.size());
  // 36 m^2 of floor and 12 m^2 of wall, one point per square centimetre, and the box's upper side.
  EXPECT_NEAR(static_cast<double>(content.sizes.fused_cloud), 15 * 1e4 * 48.64, 15 * 1e4);
  EXPECT_THAT(report::RenderReport(content), HasSubstr("cabinet_03"));
}

TEST_F(ReportOfABox, NeverShowsAFrameWithAPersonInIt) {
  const Result<ReportPage> page = Page();
  ASSERT_TRUE(page.ok());
  EXPECT_TRUE(page->content.looked_for_people);
  EXPECT_EQ(page->content.num_person_frames, 1);
  EXPECT_EQ(page->content.frame_pictures.size(), 4U);
  for (const report::Picture& picture : page->content.frame_pictures)
    EXPECT_NE(picture.caption, "frame 4");
  EXPECT_THAT(asked_for_, testing::Not(testing::Contains(DetectionId{4})));
  // A view of the object in that frame is no reason to show it.
  std::vector<ViewRegistration>& views = sources_.finished.map.map.objects[0].views;
  views.resize(1);
  views[0].view = DetectionId{4};
  views[0].frame = FrameIdx{4};
  EXPECT_THAT(Page()->content.objects[0].pictures, IsEmpty());
  // Everybody is in the pictures.
  for (DetectedFrame& frame : sources_.detected) frame.contains_person = true;
  const Result<ReportPage> none = Page();
  ASSERT_TRUE(none.ok());
  EXPECT_THAT(none->content.frame_pictures, IsEmpty());
  EXPECT_THAT(none->content.photographs, IsEmpty());
}

TEST_F(ReportOfABox, ShowsWhatIsNotMappedOutsideFramesWithPeople) {
  sources_.association.not_mapped = {
      {"shelf <1>: only 0.04 m deep", {FrameIdx{1}, {9, 9, 50, 40}}},
      {"bench: small", {FrameIdx{4}, {9, 9, 50, 40}}},
      {"tv: flush in a wall", {FrameIdx{-1}, {}}},
      {"bed: far out", {FrameIdx{0}, {-1e9, -5, 1e9, 3}}},
      {"sofa: of another capture", {FrameIdx{1000}, {9, 9, 50, 40}}}};
  const report::ReportContent content = Page()->content;
  ASSERT_EQ(content.not_mapped.size(), 5U);
  EXPECT_FALSE(content.not_mapped[0].bytes.empty());
  EXPECT_TRUE(content.not_mapped[1].bytes.empty()) << "a person is in frame 4";
  EXPECT_TRUE(content.not_mapped[2].bytes.empty());
  EXPECT_FALSE(content.not_mapped[3].bytes.empty());
  EXPECT_TRUE(content.not_mapped[4].bytes.empty());
  const std::string html = report::RenderReport(content);
  EXPECT_THAT(html, HasSubstr("Seen and not mapped"));
  for (const char* const what : {"shelf &lt;1&gt;: only", "bench: small", "tv: flush", "sofa: of"})
    EXPECT_THAT(html, HasSubstr(what));
}

TEST_F(ReportOfABox, SaysWhereNobodyLookedForPeople) {
  for (DetectedFrame& frame : sources_.detected) frame.contains_person.reset();
  const Result<ReportPage> page = Page();
  ASSERT_TRUE(page.ok());
  EXPECT_FALSE(page->content.looked_for_people);
  EXPECT_EQ(page->content.num_person_frames, 0);
  EXPECT_EQ(page->content.frame_pictures.size(), 5U);
}

TEST_F(ReportOfABox, GoesWithoutWhatCannotBeHad) {
  source_.broken = {0, 2};  // the views of the object
  sources_.finished.meshes[0] = {};
  sources_.finished.room_world = {};
  sources_.proposals.candidates[0].model = "lost";
  const Result<ReportPage> page = Page();
  ASSERT_TRUE(page.ok()) << page.error().message;
  const report::ObjectRow& row = page->content.objects[0];
  EXPECT_THAT(row.pictures, IsEmpty());
  EXPECT_THAT(row.measured_world, IsEmpty());
  EXPECT_TRUE(row.candidates[0].thumbnail.bytes.empty());
  EXPECT_EQ(row.size_m, Eigen::Vector3d::Zero());
  EXPECT_THAT(page->content.scene_pictures, IsEmpty());
  EXPECT_TRUE(page->thumbnail.bytes.empty());
  EXPECT_FALSE(report::RenderReport(page->content).empty());
}

TEST_F(ReportOfABox, AnEmptyMapHasAPageAndThePictureOfItsRoom) {
  sources_.finished.map.map.objects.clear();
  sources_.finished.meshes.clear();
  const Result<ReportPage> page = Page();
  ASSERT_TRUE(page.ok()) << page.error().message;
  EXPECT_THAT(page->content.objects, IsEmpty());
  EXPECT_FALSE(page->thumbnail.bytes.empty());
}

TEST_F(ReportOfABox, PassesOnWhatIsWrongWithTheSegmentsAndStopsWhenAsked) {
  EXPECT_EQ(Page(AskedToStop()).error().code, ErrorCode::kInterrupted);
  fault_ = InvalidInput("segments.json is damaged");
  EXPECT_EQ(Page().error().message, "segments.json is damaged");
}

}  // namespace
}  // namespace deepslam::presentation
