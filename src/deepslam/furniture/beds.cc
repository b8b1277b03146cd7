// Beds. The long side is along x, with the head behind, at -x.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct Mattress {
  double length = 0;
  double width = 0;
  double top = 0;
};

void AddPillows(Random& random, const Mattress& bed, Solids& solids) {
  const int pillows = bed.width > 1.2 ? 2 : 1;
  for (int n = 0; n < pillows; ++n) {
    const double y = pillows == 1 ? 0.0 : (n - 0.5) * 0.5 * bed.width;
    solids.Cushion(Material::kDetail,
                   {-0.5 * bed.length + 0.25, y, bed.top + 0.05},
                   {random.Uniform(0.35, 0.5), std::min(0.75, 0.86 * bed.width / pillows), 0.15},
                   0.7,
                   0.35);
  }
}

// The end behind the pillows.
struct HeadEnd {
  double end = 0;  // from the middle of the bed
  double width = 0;
  double thickness = 0;
  double head = 0;  // its upper edge
  double rail_low = 0;
};

void AddHead(Random& random, const HeadEnd& bed, Solids& solids) {
  const auto& [end, width, thickness, head, rail_low] = bed;
  const std::size_t kind = Pick(random, std::array{1.0, 0.5, 0.4, 0.25});
  if (kind == 0) {
    solids.Box(
        Material::kBody, {-end - 0.5 * thickness, 0, 0.5 * head}, {thickness, width + 0.06, head});
  } else if (kind == 1) {
    solids.Cushion(Material::kBody,
                   {-end - 0.5 * thickness, 0, 0.5 * (head + rail_low)},
                   {thickness + 0.05, width + 0.06, head - rail_low},
                   0.3,
                   0.2);
  } else if (kind == 2) {  // bars
    for (const double side : kSides)
      solids.Box(
          Material::kFrame, {-end - 0.02, side * 0.5 * width, 0.5 * head}, {0.05, 0.05, head});
    solids.Box(Material::kFrame, {-end - 0.02, 0, head - 0.02}, {0.05, width, 0.05});
    const int bars = Count(random, 3, 10);
    for (int n = 0; n < bars; ++n) {
      const double y = width * (static_cast<double>(n + 1) / (bars + 1) - 0.5);
      solids.Box(Material::kFrame,
                 {-end - 0.02, y, 0.5 * (head + rail_low)},
                 {0.02, 0.02, head - rail_low});
    }
  }
}

}  // namespace

void BuildBed(Random& random, Solids& solids) {
  const double length = random.Uniform(1.75, 2.12);
  const double width = Chance(random, 0.5) ? random.Uniform(0.8, 1.2) : random.Uniform(1.3, 2.0);
  const double rail_height = random.Uniform(0.14, 0.3);
  const double rail_low = Chance(random, 0.75) ? random.Uniform(0.1, 0.3) : 0.02;
  const double mattress = random.Uniform(0.12, 0.28);
  const double top = rail_low + 0.6 * rail_height + mattress;
  solids.Box(Material::kFrame,
             {0, 0, rail_low + 0.5 * rail_height},
             {length + 0.05, width + 0.05, rail_height});
  solids.Cushion(Material::kTop,
                 {0, 0, top - 0.5 * mattress},
                 {length, width, mattress},
                 random.Uniform(0.1, 0.3),
                 0.08);
  if (Chance(random, 0.5)) {  // blanket, hanging over the sides
    const double over = random.Uniform(0.02, 0.06);
    const double share = random.Uniform(0.55, 0.8);
    solids.Cushion(Material::kDetail,
                   {0.5 * length * (1 - share), 0, top - 0.25 * mattress},
                   {share * length + 0.04, width + over, 0.6 * mattress},
                   0.2,
                   0.1);
  }
  if (Chance(random, 0.75)) AddPillows(random, {length, width, top}, solids);
  const double thickness = random.Uniform(0.03, 0.1);
  const double end = 0.5 * length + 0.025;
  const double head = top + random.Uniform(0.15, 0.7);
  AddHead(random, {end, width, thickness, head, rail_low}, solids);
  if (Chance(random, 0.35)) {
    const double foot = rail_low + rail_height + random.Uniform(0.02, 0.35);
    solids.Box(
        Material::kBody, {end + 0.5 * thickness, 0, 0.5 * foot}, {thickness, width + 0.06, foot});
  }
  if (rail_low > 0.05) Feet(random, {{length, width}, rail_low, 0.01}, solids);
}

}  // namespace deepslam::furniture
