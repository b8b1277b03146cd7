#include "deepslam/report/report.h"

#include <gmock/gmock.h>

#include "deepslam/report/draw.h"
#include "deepslam/report/html.h"

namespace deepslam::report {
namespace {

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

TEST(RenderReport, NamesFromOutsideStayText) {
  ReportContent content = SmallContent();
  content.title = "<script>alert(1)</script>";
  content.objects[0].name = "a'\"&<b>";
  const std::string page = RenderReport(content);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, HasSubstr("a&#39;&quot;&amp;&lt;b&gt;"));
}

TEST(RenderReport, AnEmptyMapIsAPageThatSaysSo) {
  EXPECT_THAT(RenderReport(ReportContent{}), HasSubstr("No object entered the map"));
}

TEST(RenderReport, SameContentSameBytes) {
  EXPECT_EQ(RenderReport(SmallContent()), RenderReport(SmallContent()));
}

TEST(Base64Test, AgreesWithRfc4648) {
  // RFC 4648, section 10.
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
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
