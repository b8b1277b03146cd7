#include "deepslam/report/floor_plan.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

#include "support/layout_samples.h"

namespace deepslam::report {
namespace {

using testing::HasSubstr;
using testing::Not;

FloorPlanContent TwoRooms() {
  FloorPlanContent content;
  content.title = "home <1>";
  content.layout_world = testing_support::TwoRoomLayout();
  content.things = {MakePlanThing("table_02",
                                  {Eigen::Quaterniond::Identity(), {2, 1.5, 0.4}},
                                  {0.8, 1.6, 0.75},
                                  {10, 200, 30})};
  return content;
}

std::size_t CountOf(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

TEST(FloorPlan, ShowsWallsOpeningsFurnitureAndMeasures) {
  const std::string svg = FloorPlan(TwoRooms());
  EXPECT_EQ(CountOf(svg, "<polygon class='fp-wall'"), 8U);
  EXPECT_EQ(CountOf(svg, "<polygon class='fp-gap'"), 2U);
  EXPECT_EQ(CountOf(svg, "<path class='fp-arc'"), 1U);
  EXPECT_EQ(CountOf(svg, "<path class='fp-pane'"), 2U);
  EXPECT_EQ(CountOf(svg, "<g class='fp-doubtful'>"), 1U) << "the window";
  EXPECT_THAT(svg, HasSubstr("table_02"));
  EXPECT_THAT(svg, HasSubstr("0.80 x 1.60 x 0.75"));
  EXPECT_THAT(svg, HasSubstr("12.0 m²"));
  EXPECT_THAT(svg, HasSubstr("Room 1"));
  EXPECT_THAT(svg, HasSubstr(">8.10</text>")) << "the whole width";
  EXPECT_THAT(svg, HasSubstr("home &lt;1&gt;"));
}

// Files that are opened by themselves have to be XML: every attribute in quotes.
TEST(FloorPlan, IsXml) {
  const std::string svg = FloorPlan(TwoRooms());
  EXPECT_THAT(svg, testing::StartsWith("<svg xmlns='http://www.w3.org/2000/svg'"));
  bool in_tag = false;
  char quote = 0;
  for (std::size_t n = 0; n < svg.size(); ++n) {
    if (quote != 0) {
      if (svg[n] == quote) quote = 0;
    } else if (in_tag && (svg[n] == '\'' || svg[n] == '"')) {
      quote = svg[n];
    } else if (svg[n] == '<') {
      in_tag = true;
    } else if (svg[n] == '>') {
      in_tag = false;
    } else if (in_tag && svg[n] == '=') {
      EXPECT_TRUE(svg[n + 1] == '\'' || svg[n + 1] == '"') << svg.substr(n > 20 ? n - 20 : 0, 40);
    }
  }
}

TEST(PlanCanvas, IsTurnedWithTheWallsAndTrueToScale) {
  for (const double angle : {0.0, 0.3, -0.6, 1.2}) {
    FloorPlanContent content = TwoRooms();
    const Eigen::Rotation2Dd turn(angle);
    for (LayoutRoom& room : content.layout_world.rooms) {
      for (Eigen::Vector2d& p : room.polygon_m) p = turn * p;
    }
    for (LayoutWall& wall : content.layout_world.walls) {
      wall.from_m = turn * wall.from_m;
      wall.to_m = turn * wall.to_m;
    }
    content.things.clear();
    const PlanCanvas canvas(content);
    for (const LayoutWall& wall : content.layout_world.walls) {
      const Eigen::Vector2d drawn = canvas.ToPixels(wall.to_m) - canvas.ToPixels(wall.from_m);
      EXPECT_NEAR(drawn.norm(), kPlanPixelsPerMetre * wall.length_m(), 1e-6);
      EXPECT_NEAR(drawn.cwiseAbs().minCoeff(), 0, 1e-6) << angle;
      for (const Eigen::Vector2d& p : {canvas.ToPixels(wall.from_m), canvas.ToPixels(wall.to_m)}) {
        EXPECT_GE(p.minCoeff(), 0);
        EXPECT_LE(p.x(), canvas.width_px());
        EXPECT_LE(p.y(), canvas.height_px());
      }
    }
  }
}

TEST(FloorPlan, MarksSidesThatWereGuessed) {
  FloorPlanContent content = TwoRooms();
  EXPECT_THAT(FloorPlan(content), Not(HasSubstr("<path class='fp-guessed'")));
  content.layout_world.rooms[0].guessed[3] = true;
  EXPECT_EQ(CountOf(FloorPlan(content), "<path class='fp-guessed'"), 1U);
}

TEST(FloorPlan, OfNothingAndOfFurnitureAlone) {
  EXPECT_THAT(FloorPlan({}), HasSubstr("</svg>"));
  FloorPlanContent content = TwoRooms();
  content.layout_world = {};
  const std::string svg = FloorPlan(content, [](const PlanCanvas&) { return "<g id='over'/>"; });
  EXPECT_THAT(svg, HasSubstr("table_02"));
  EXPECT_THAT(svg, HasSubstr("<g id='over'/>"));
}

}  // namespace
}  // namespace deepslam::report
