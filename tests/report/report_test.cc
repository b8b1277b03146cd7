#include "deepslam/report/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "deepslam/core/base64.h"
#include "deepslam/report/draw.h"
#include "deepslam/report/explain.h"
#include "deepslam/report/html.h"
#include "deepslam/report/plots.h"
#include "deepslam/report/viewer_section.h"

namespace deepslam::report {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

ReportContent SmallContent() {
  ReportContent content;
  content.title = "kitchen";
  content.verdict = "doubtful";
  content.verdict_reasons = {"2 of 3 frames were lost"};
  for (int i = 0; i < 3; ++i) {
    TrackedFrame frame;
    frame.frame = FrameIdx{i};
    frame.status = i == 0 ? TrackingStatus::kTracked : TrackingStatus::kLost;
    frame.world_from_camera.translation_m = Eigen::Vector3d(0.1 * i, 0.2 * i, 1.4);
    content.map.frames.push_back(frame);
  }
  content.map.keyframes = {FrameIdx{0}};
  ObjectRow chair;
  chair.name = "chair_01";
  chair.size_m = Eigen::Vector3d(0.5, 0.45, 0.9);
  content.objects.push_back(chair);
  return content;
}

TEST(RenderReport, SaysTheVerdictAndEveryObject) {
  const std::string page = RenderReport(SmallContent());
  EXPECT_THAT(page, HasSubstr("Result: doubtful"));
  EXPECT_THAT(page, HasSubstr("2 of 3 frames were lost"));
  EXPECT_THAT(page, HasSubstr("chair_01"));
  EXPECT_THAT(page, HasSubstr("<b>1</b> tracked, 0 with a weak direction, 2 lost"));
}

TEST(Facts, NameTheObjectsThatAreMoreLikelyWrongThanRight) {
  ReportContent content = SmallContent();
  const auto objects = [&] {
    const std::vector<Fact> facts = Facts(content);
    return *std::find_if(
        facts.begin(), facts.end(), [](const Fact& fact) { return fact.subject == "Objects"; });
  };
  content.objects[0].confidence = 0.9;
  EXPECT_TRUE(objects().fine);
  content.objects[0].note = "seen from one side only";  // as everything that stands at a wall
  EXPECT_TRUE(objects().fine);
  EXPECT_THAT(objects().finding, HasSubstr("notes on 1 of them"));
  content.objects[0].confidence = 0.4;
  EXPECT_FALSE(objects().fine);
  EXPECT_THAT(objects().finding, HasSubstr("unsure: chair_01"));
  EXPECT_FALSE(objects().remedy.empty());
}

TEST(RenderReport, LoopsAreToldOfByTheirKind) {
  ReportContent content = SmallContent();
  EXPECT_THAT(RenderReport(content), HasSubstr("Places seen again</h2><p>None"));
  Constellation two;
  two.pairs = {{ObjectId{1}, ObjectId{5}}, {ObjectId{2}, ObjectId{6}}};
  two.accepted = true;
  two.reason = "objects <agree>";
  Constellation one;
  one.pairs = {{ObjectId{3}, ObjectId{7}}};
  one.reason = "models overlap by 2 %";
  content.loops.constellations = {one, two};
  for (int k = 0; k < 4; ++k) {
    content.loops.appearance.push_back({FrameIdx{10 + k},
                                        FrameIdx{400 + k},
                                        Pose3(),
                                        40,
                                        3,
                                        0.9,
                                        k > 0,
                                        k > 0 ? "agree" : "alone"});
  }
  std::string page = RenderReport(content);
  EXPECT_THAT(page,
              HasSubstr("<td>constellation<td>objects 05 is 01, 06 is 02<td>accepted<td>objects "
                        "&lt;agree&gt;"));
  EXPECT_THAT(page, HasSubstr("<td>duplicate<td>object 07 is 03<td>refused<td>models overlap"));
  EXPECT_THAT(page,
              HasSubstr("<td>appearance<td>frames 11 to 13 and frames 401 to 403, 3 pairs"
                        "<td>accepted<td>agree"));
  EXPECT_THAT(page, HasSubstr("<td>appearance<td>frame 10 and frame 400, 1 pair<td>refused"));
  content.loops.tracklets = {{ObjectId{7}, ObjectId{2}, FrameIdx{80}, FrameIdx{95}}};
  page = RenderReport(content);
  EXPECT_THAT(page, HasSubstr("object 02 (as seen in frames 80 to 95) is 03"));
}

TEST(RenderReport, NamesFromOutsideStayText) {
  ReportContent content = SmallContent();
  content.title = "<script>alert(1)</script>";
  content.objects[0].name = "a'\"&<b>";
  const std::string page = RenderReport(content);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("a&#39;&quot;&amp;&lt;b&gt;"));
}

TEST(RenderReport, FramesWithPeopleAreToldOfAndUncheckedOnesToo) {
  ReportContent content = SmallContent();
  content.num_person_frames = 2;
  EXPECT_THAT(RenderReport(content), HasSubstr("seen in 2 frames, which this page leaves out"));
  content.num_person_frames = 0;
  EXPECT_THAT(RenderReport(content), HasSubstr("no person was seen"));
  content.looked_for_people = false;
  EXPECT_THAT(RenderReport(content), Not(HasSubstr("no person was seen")));
}

TEST(RenderReport, CorrectionsByHandAreShownAsText) {
  ReportContent content = SmallContent();
  EXPECT_THAT(RenderReport(content), Not(HasSubstr("Corrected by hand")));
  content.corrections = {"object 3 was dropped", "object 4 is a <table>"};
  const std::string page = RenderReport(content);
  EXPECT_THAT(page, HasSubstr("Corrected by hand"));
  EXPECT_THAT(page, HasSubstr("<li>object 3 was dropped"));
  EXPECT_THAT(page, HasSubstr("&lt;table&gt;"));
}

TEST(RenderReport, SizesStandBesideEachOtherWithTheirRatios) {
  ReportContent content = SmallContent();
  content.objects.push_back(content.objects.front());
  content.sizes = {4000, 60'000, 800'000, 6'000'000};
  const std::string page = RenderReport(content);
  EXPECT_THAT(page, HasSubstr("map.json takes 4.0 KB, 2.0 KB an object"));
  EXPECT_THAT(page, HasSubstr("fused point cloud takes 6.0 MB, 1500 times as much"));
  for (const char* ratio : {"1500 x", "100 x", "8 x"}) EXPECT_THAT(page, HasSubstr(ratio));
  content.objects.clear();  // nothing to divide by
  EXPECT_THAT(RenderReport(content), HasSubstr("1500 x"));
  content.sizes = {};
  EXPECT_THAT(RenderReport(content), Not(HasSubstr("map.json takes")));
}

TEST(RenderReport, AsksForNothingThatCouldBeMissingAloud) {
  // A missing script or picture is an error on the console; a missing frame is not.
  const std::string page = RenderReport(SmallContent());
  EXPECT_THAT(page, Not(HasSubstr("<script src")));
  EXPECT_THAT(page, HasSubstr("<iframe id=timing-source src='../timing.html' hidden"));
}

TEST(RenderReport, WithoutASceneThePageSaysSoInPlaceOfTheView) {
  const std::string page = RenderReport(SmallContent());
  EXPECT_THAT(page, HasSubstr("There is no scene to show"));
  EXPECT_THAT(page, Not(HasSubstr("id=viewer>")));
}

TEST(Facts, SayWhereTheCameraWasNotHeldUpright) {
  ReportContent content = SmallContent();
  content.map.has_ground = true;
  const auto finding = [&](double roll_rad) {
    Eigen::Matrix3d level;  // world z up, looking along x
    level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    for (TrackedFrame& frame : content.map.frames) {
      frame.world_from_camera.rotation =
          level * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    }
    return Facts(content)[1].finding;
  };
  EXPECT_THAT(finding(0.2), Not(HasSubstr("turned")));
  EXPECT_THAT(finding(1.6), HasSubstr("turned"));
  EXPECT_THAT(finding(-3.0), HasSubstr("turned"));
}

TEST(Facts, EveryFaultHasARemedyAndNothingFineHasOne) {
  ReportContent content = SmallContent();
  content.objects[0].note = "seen from one side only";
  for (const Fact& fact : Facts(content)) EXPECT_EQ(fact.fine, fact.remedy.empty()) << fact.subject;
  for (const Fact& fact : Facts(ReportContent{}))
    EXPECT_EQ(fact.fine, fact.remedy.empty()) << fact.subject;
}

TEST(WhyItWon, NamesOnlyWhatSpeaksForTheWinner) {
  ObjectRow object;
  EXPECT_EQ(WhyItWon(object), "");
  CandidateRow winner;
  winner.model = "a";
  winner.score = 0.7;
  winner.surface_share = 0.9;
  winner.coverage_share = 0.5;
  winner.chosen = true;
  CandidateRow next = winner;
  next.model = "b";
  next.chosen = false;
  next.surface_share = 0.6;
  next.coverage_share = 0.8;  // speaks for the other one
  object.candidates = {next, winner};
  const std::string why = WhyItWon(object);
  EXPECT_THAT(why, HasSubstr("90 % against 60 %"));
  EXPECT_THAT(why, Not(HasSubstr("50 %")));
  EXPECT_THAT(why, Not(HasSubstr("Set aside")));
  object.candidates.push_back(next);
  CandidateRow& better = object.candidates.back();
  better.model = "fused_0";
  better.source = "own measurement";
  better.is_partial = true;
  better.score = 0.9;
  EXPECT_THAT(WhyItWon(object), HasSubstr("Set aside in spite of a higher score: fused_0"));
  EXPECT_THAT(WhyItWon(object), HasSubstr("lacks the sides nobody saw"));
  better.is_partial = false;
  EXPECT_THAT(WhyItWon(object), HasSubstr("turns its back"));
  object.candidates.front().num_views = 9;
  better.num_views = 4;
  EXPECT_THAT(WhyItWon(object), HasSubstr("in 4 views only, others in 9"));
}

TEST(ViewerData, CannotEndItsScriptElementAndStaysFinite) {
  ReportContent content = SmallContent();
  content.objects[0].name = "</script><script>alert(1)</script>";
  content.objects[0].credit = "broken \xff text";
  content.objects[0].confidence = std::numeric_limits<double>::quiet_NaN();
  const std::string data = ViewerData(content);
  EXPECT_THAT(data, Not(HasSubstr("<")));
  EXPECT_THAT(data, Not(HasSubstr("nan")));
}

TEST(ViewerData, MeasuredPointsComeBackToTheMillimetre) {
  ReportContent content = SmallContent();
  content.objects[0].measured_world = {{1.0f, -2.0f, 0.5f}, {1.25f, -1.0f, 0.5f}};
  const std::string data = ViewerData(content);
  EXPECT_THAT(data, HasSubstr("\"origin_m\":[1.0,-2.0,0.5]"));
  // 0, 0, 0 and 250, 1000, 0 as 16-bit little endian.
  EXPECT_THAT(data, HasSubstr(EncodeBase64(std::string("\0\0\0\0\0\0\xFA\0\xE8\x03\0\0", 12))));
}

// Rounds of a circle, one frame of them lost, one at a height of its own.
ReportContent Rounds(int num_frames) {
  ReportContent content;
  for (int k = 0; k < num_frames; ++k) {
    TrackedFrame frame;
    frame.frame = FrameIdx{k};
    frame.status = TrackingStatus::kTracked;
    const double angle = 0.01 * k;
    frame.world_from_camera.translation_m = {
        3 * std::cos(angle), 3 * std::sin(angle), 1.4 + 0.01 * std::sin(0.7 * k)};
    content.map.frames.push_back(frame);
    content.tracked_world_from_camera.push_back(frame.world_from_camera);
    if (k % 4 == 0) content.map.keyframes.push_back(frame.frame);
  }
  const auto middle = static_cast<std::size_t>(num_frames / 2);
  content.map.frames[middle].status = TrackingStatus::kLost;
  content.map.frames[middle + 2].world_from_camera.translation_m.z() = 2;
  return content;
}

TEST(Plots, OfHoursAreNotMuchLargerThanOfMinutesAndShowWhatIsAmiss) {
  const auto size = [](const std::string& text) { return static_cast<double>(text.size()); };
  const ReportContent minutes = Rounds(3'000);
  const ReportContent hours = Rounds(100'000);
  EXPECT_LT(size(HeightOverTime(hours.map.frames)), 4 * size(HeightOverTime(minutes.map.frames)));
  EXPECT_LT(size(GraphCorrection(hours.map.frames, hours.tracked_world_from_camera)),
            4 * size(GraphCorrection(minutes.map.frames, minutes.tracked_world_from_camera)));
  EXPECT_LT(size(PlanWithPath(hours)), 3e6)
      << "rounds over each other are drawn by their lines alone";
  for (const ReportContent* content : {&minutes, &hours}) {
    const std::string height = HeightOverTime(content->map.frames);
    EXPECT_THAT(height, HasSubstr("#d62828")) << "the lost frame";
    EXPECT_THAT(PlanWithPath(*content), HasSubstr("#d62828"));
    EXPECT_THAT(height, ContainsRegex("L36[0-9.]+ 11\\.8")) << "the one frame that is higher";
  }
}

TEST(HeightDrift, WithoutTwoObservationsOfTheFloorThereIsNoPlot) {
  const HeightCheck one[] = {{FrameIdx{0}, 1, 1, 1}};
  EXPECT_EQ(HeightDrift(one, 10), "");
  const HeightCheck two[] = {{FrameIdx{0}, 1, 1, 1}, {FrameIdx{9}, 1, 1.1, 1}};
  EXPECT_THAT(HeightDrift(two, 10), HasSubstr("10 cm"));
}

TEST(RenderReport, AnEmptyMapIsAPageThatSaysSo) {
  EXPECT_THAT(RenderReport(ReportContent{}), HasSubstr("No object entered the map"));
}

TEST(RenderReport, SameContentSameBytes) {
  EXPECT_EQ(RenderReport(SmallContent()), RenderReport(SmallContent()));
}

TEST(DrawOverlaysTest, ScalesDownAndRefusesNothing) {
  const ColourImage picture(64, 48, Rgb8{10, 20, 30});
  Overlay overlay;
  overlay.box_px = {4, 4, 30, 30};
  overlay.mask = Mask(64, 48, 1);
  overlay.label = "chair 0.9";
  const Overlay overlays[] = {overlay};
  const Result<std::string> jpeg = DrawOverlays(picture, overlays, 32);
  ASSERT_TRUE(jpeg.ok());
  EXPECT_EQ(jpeg->substr(0, 2), "\xFF\xD8");
  EXPECT_FALSE(DrawOverlays(ColourImage(), overlays, 32).ok());
  EXPECT_TRUE(DrawOutline(picture, Mask(64, 48, 1), Rgb8{255, 0, 0}, 128).ok());
  // A mask of another size is left out rather than read beyond its end.
  EXPECT_TRUE(DrawOutline(picture, Mask(3, 3, 1), Rgb8{255, 0, 0}, 128).ok());
}

}  // namespace
}  // namespace deepslam::report
