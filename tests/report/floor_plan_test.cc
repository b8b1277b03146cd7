#include "deepslam/report/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "report/two_room_plan.h"

namespace deepslam::report {
namespace {

using testing::HasSubstr;
using testing::Not;

std::size_t CountOf(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
    ++count;
  return count;
}

TEST(FloorPlan, ShowsWallsOpeningsFurnitureAndMeasures) {
  const std::string svg = FloorPlan(TwoRoomPlan());
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
  const std::string svg = FloorPlan(TwoRoomPlan());
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
    FloorPlanContent content = TwoRoomPlan();
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
  FloorPlanContent content = TwoRoomPlan();
  EXPECT_THAT(FloorPlan(content), Not(HasSubstr("<path class='fp-guessed'")));
  // A wall that was seen in a part of its side alone leaves the rest of it.
  content.layout_world.walls[3].from_m = {0, 1.5};
  EXPECT_EQ(CountOf(FloorPlan(content), "<path class='fp-guessed'"), 1U);
  content.layout_world.walls[0].rooms.clear();
  EXPECT_EQ(CountOf(FloorPlan(content), "<path class='fp-guessed'"), 2U);
}

// Where texts of a class stand.
std::vector<Eigen::Vector2d> PlacesOf(const std::string& svg, const std::string& css_class) {
  const std::regex group("<g transform='translate\\(([-0-9.]+) ([-0-9.]+)\\)[^']*'><text class='" +
                         css_class + "'");
  std::vector<Eigen::Vector2d> places;
  for (std::sregex_iterator at(svg.begin(), svg.end(), group), end; at != end; ++at)
    places.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  return places;
}

// Furniture before the middles of walls, where lengths would stand.
TEST(FloorPlan, LengthsStandBesideNamesAndNotOverThem) {
  FloorPlanContent content = TwoRoomPlan();
  for (const double x : {2.0, 6.1}) {
    content.things.push_back(MakePlanThing(
        "cabinet", {Eigen::Quaterniond::Identity(), {x, 0.15, 0.4}}, {1.2, 0.3, 0.8}, {}));
  }
  const std::string svg = FloorPlan(content);
  const std::vector<Eigen::Vector2d> lengths = PlacesOf(svg, "fp-length");
  const std::vector<Eigen::Vector2d> names = PlacesOf(svg, "fp-name");
  EXPECT_EQ(lengths.size(), 8U) << "one for each wall";
  ASSERT_EQ(names.size(), 3U);
  for (const Eigen::Vector2d& length : lengths) {
    for (const Eigen::Vector2d& name : names) {
      const Eigen::Vector2d apart = (length - name).cwiseAbs();
      EXPECT_TRUE(apart.x() > 25 || apart.y() > 10) << length.transpose();
    }
  }
}

TEST(FloorPlan, TellsHowWideAndHighOpeningsAre) {
  const std::string svg = FloorPlan(TwoRoomPlan());
  EXPECT_THAT(svg, HasSubstr("0.90 x 2.00"));
  EXPECT_THAT(svg, HasSubstr("1.20 x 1.20"));
}

TEST(FloorPlan, OfNothingAndOfFurnitureAlone) {
  EXPECT_THAT(FloorPlan({}), HasSubstr("</svg>"));
  FloorPlanContent content = TwoRoomPlan();
  content.layout_world = {};
  const std::string svg = FloorPlan(content, [](const PlanCanvas&) { return "<g id='over'/>"; });
  EXPECT_THAT(svg, HasSubstr("table_02"));
  EXPECT_THAT(svg, HasSubstr("<g id='over'/>"));
}

}  // namespace
}  // namespace deepslam::report
