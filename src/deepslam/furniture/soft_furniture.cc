// Sofas and beds. A sofa's long side is along y, a bed's along x with its head behind, at -x.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

constexpr std::array<double, 2> kSides = {-1.0, 1.0};

struct SofaPlan {
  double width = 0;  // between the arms
  double depth = 0;  // with the back
  double seat = 0;   // height
  double feet = 0;
  double arm = 0;
  double arm_height = 0;
  double back = 0;
  double back_height = 0;
  int places = 2;
};

SofaPlan DrawSofa(Random& random) {
  SofaPlan plan;
  plan.places = 1 + static_cast<int>(Pick(random, std::array{0.12, 1.0, 1.0, 0.35}));
  plan.width = plan.places * random.Uniform(0.54, 0.72);
  plan.depth = random.Uniform(0.75, 1.02);
  plan.seat = random.Uniform(0.36, 0.48);
  plan.feet = random.Uniform(0.02, 0.17);
  plan.arm = Chance(random, 0.15) ? 0.0 : random.Uniform(0.07, 0.26);
  plan.arm_height = plan.seat + random.Uniform(0.06, 0.26);
  plan.back = random.Uniform(0.12, 0.26);
  plan.back_height = plan.seat + random.Uniform(0.26, 0.52);
  return plan;
}

void SofaArms(Random& random, const SofaPlan& plan, Solids& solids) {
  if (plan.arm <= 0) return;
  const std::size_t kind = Pick(random, std::array{1.0, 0.8, 0.5});
  const double height = plan.arm_height - plan.feet;
  for (const double side : kSides) {
    const Eigen::Vector3d middle(0, side * 0.5 * (plan.width + plan.arm), plan.feet + 0.5 * height);
    const Eigen::Vector3d size(plan.depth, plan.arm, height);
    if (kind == 0) {
      solids.Box(Material::kBody, middle, size);
    } else if (kind == 1) {
      solids.Cushion(Material::kBody, middle, size, random.Uniform(0.15, 0.35), 0.15);
    } else {  // rolled
      const double r = 0.6 * plan.arm;
      solids.Box(Material::kBody, middle, {size.x(), 0.8 * size.y(), size.z()});
      solids.Tube(Material::kBody,
                  {{-0.5 * plan.depth, middle.y(), plan.arm_height - 0.5 * r},
                   {0.5 * plan.depth, middle.y(), plan.arm_height - 0.5 * r}},
                  r,
                  r,
                  14);
    }
  }
}

void SeatCushions(
    Random& random, const SofaPlan& plan, double chaise, double chaise_side, Solids& solids) {
  const double thickness = random.Uniform(0.1, 0.2);
  const double roundness = random.Uniform(0.2, 0.45);
  const bool one = Chance(random, 0.25);
  const int count = one ? 1 : plan.places;
  const double width = plan.width / count;
  const double back_x = -0.5 * plan.depth + plan.back;
  const double lean = random.Uniform(0.0, 0.3);
  const double back_cushion = random.Uniform(0.1, 0.2);
  const bool cushions_behind = Chance(random, 0.7);
  for (int n = 0; n < count; ++n) {
    const double y = -0.5 * plan.width + width * (n + 0.5);
    const bool long_one = chaise > 0 && n == (chaise_side > 0 ? count - 1 : 0);
    const double front = 0.5 * plan.depth + (long_one ? chaise : 0.0) + 0.015;
    solids.Cushion(Material::kTop,
                   {0.5 * (back_x + front), y, plan.seat - 0.5 * thickness},
                   {front - back_x, width - 0.008, thickness},
                   roundness,
                   0.15);
    if (!cushions_behind) continue;
    const double height = plan.back_height - plan.seat + random.Uniform(-0.04, 0.06);
    solids.Cushion(Material::kTop,
                   {back_x + 0.4 * back_cushion, y, plan.seat + 0.5 * height - 0.02},
                   {back_cushion, width - 0.012, height},
                   roundness,
                   0.2,
                   [&](const Eigen::Vector3d& p) {
                     return Eigen::Vector3d(p.x() - lean * p.z(), p.y(), p.z());
                   });
  }
}

}  // namespace

void BuildSofa(Random& random, Solids& solids) {
  const SofaPlan plan = DrawSofa(random);
  const double total = plan.width + 2 * plan.arm;
  const double box_top = plan.seat - 0.06;
  solids.Box(Material::kBody,
             {0, 0, 0.5 * (plan.feet + box_top)},
             {plan.depth - 0.02, total - 0.02, box_top - plan.feet});
  const double chaise = plan.places >= 2 && Chance(random, 0.15) ? random.Uniform(0.35, 0.7) : 0.0;
  const double side = Chance(random, 0.5) ? 1.0 : -1.0;
  if (chaise > 0) {
    const double width = plan.width / plan.places;
    const double y = side * (0.5 * plan.width - 0.5 * width);
    solids.Box(Material::kBody,
               {0.5 * plan.depth + 0.5 * chaise - 0.02, y, 0.5 * (plan.feet + box_top)},
               {chaise, width, box_top - plan.feet});
    for (const double end : kSides)
      solids.Box(Material::kFrame,
                 {0.5 * plan.depth + chaise - 0.09, y + 0.4 * end * width, 0.5 * plan.feet},
                 {0.05, 0.05, plan.feet + 0.01});
  }
  // Back: upright or leaning, straight or rounded above.
  const double lean = Chance(random, 0.5) ? random.Uniform(0.0, 0.25) : 0.0;
  const double low = plan.feet + 0.01;
  const double roundness = Chance(random, 0.5) ? 0.05 : random.Uniform(0.15, 0.4);
  solids.Cushion(Material::kBody,
                 {-0.5 * plan.depth + 0.5 * plan.back, 0, 0.5 * (low + plan.back_height)},
                 {plan.back, Chance(random, 0.6) ? total : plan.width, plan.back_height - low},
                 roundness,
                 0.12,
                 [&](const Eigen::Vector3d& p) {
                   return Eigen::Vector3d(p.x() - lean * p.z(), p.y(), p.z());
                 });
  SofaArms(random, plan, solids);
  SeatCushions(random, plan, chaise, side, solids);
  Feet(random, {{plan.depth, total}, plan.feet, random.Uniform(0.02, 0.08)}, solids);
}

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
  if (Chance(random, 0.75)) {
    const int pillows = width > 1.2 ? 2 : 1;
    for (int n = 0; n < pillows; ++n) {
      const double y = pillows == 1 ? 0.0 : (n - 0.5) * 0.5 * width;
      solids.Cushion(Material::kDetail,
                     {-0.5 * length + 0.25, y, top + 0.05},
                     {random.Uniform(0.35, 0.5), std::min(0.75, 0.86 * width / pillows), 0.15},
                     0.7,
                     0.35);
    }
  }
  const double thickness = random.Uniform(0.03, 0.1);
  const double end = 0.5 * length + 0.025;
  const double head = top + random.Uniform(0.15, 0.7);
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
  if (Chance(random, 0.35)) {
    const double foot = rail_low + rail_height + random.Uniform(0.02, 0.35);
    solids.Box(
        Material::kBody, {end + 0.5 * thickness, 0, 0.5 * foot}, {thickness, width + 0.06, foot});
  }
  if (rail_low > 0.05) Feet(random, {{length, width}, rail_low, 0.01}, solids);
}

}  // namespace deepslam::furniture
