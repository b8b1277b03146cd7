// Sofas that are cushions on a frame of wood or metal, open below: on legs, sledges, or frames at
// both ends that are legs and arms in one. The long side is along y.
#include <algorithm>
#include <array>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

struct FramePlan {
  int places = 2;
  double width = 0;    // of the deck
  double depth = 0;    // of the deck
  double deck = 0;     // height of its upper side
  double rail = 0;     // thickness of the frame's parts
  double cushion = 0;  // thickness of the seat's
  double back_top = 0;
  double back = 0;  // thickness
  double lean = 0;  // of the back, backwards for each metre up

  [[nodiscard]] double seat() const { return deck + cushion; }
  [[nodiscard]] double rear() const { return -0.5 * depth; }
  // How far behind the deck's rear rim the back's front stands at a height.
  [[nodiscard]] double Behind(double z) const { return lean * (z - deck); }
};

FramePlan DrawFrame(Random& random) {
  FramePlan plan;
  plan.places = 1 + static_cast<int>(Pick(random, std::array{0.1, 1.0, 1.0, 0.15}));
  plan.width = plan.places * random.Uniform(0.5, 0.76);
  plan.depth = random.Uniform(0.52, 0.9);
  plan.cushion = random.Uniform(0.05, 0.22);
  plan.deck = std::max(0.12, random.Uniform(0.32, 0.48) - plan.cushion);
  plan.rail = random.Uniform(0.02, 0.06);
  plan.back_top = plan.seat() + random.Uniform(0.24, 0.55);
  plan.back = random.Uniform(0.05, 0.2);
  plan.lean = Chance(random, 0.3) ? 0.0 : random.Uniform(0.05, 0.4);
  return plan;
}

// What cushions lie on: a board, or rails round slats.
void Deck(Random& random, const FramePlan& plan, Solids& solids) {
  const double high = random.Uniform(0.02, 0.1);
  const double z = plan.deck - 0.5 * high;
  if (Chance(random, 0.4)) {
    solids.Box(Material::kFrame, {0, 0, z}, {plan.depth, plan.width, high});
    return;
  }
  for (const double side : kSides) {
    solids.Box(Material::kFrame,
               {side * 0.5 * (plan.depth - plan.rail), 0, z},
               {plan.rail, plan.width, high});
    solids.Box(Material::kFrame,
               {0, side * 0.5 * (plan.width - plan.rail), z},
               {plan.depth, plan.rail, high});
  }
  const int slats = Count(random, 2, 6);
  for (int n = 0; n < slats; ++n)
    solids.Box(Material::kFrame,
               {0, plan.width * ((n + 0.5) / slats - 0.5), plan.deck - 0.02},
               {plan.depth - 0.01, 0.05, 0.02});
}

void SeatCushions(Random& random, const FramePlan& plan, Solids& solids) {
  const int count = Chance(random, 0.35) ? 1 : plan.places;
  const double roundness = random.Uniform(0.05, 0.45);
  const double over = random.Uniform(-0.01, 0.04);  // beyond the deck's front
  const double width = plan.width / count;
  for (int n = 0; n < count; ++n)
    solids.Cushion(
        Material::kTop,
        {0.5 * over, width * (n + 0.5) - 0.5 * plan.width, plan.deck + 0.49 * plan.cushion},
        {plan.depth + over, width - 0.006, 1.02 * plan.cushion},
        roundness,
        0.12);
}

// Posts at both ends with bars or a board between them.
void BackFrame(Random& random, const FramePlan& plan, double top, Solids& solids) {
  const double low = plan.deck - 0.02;
  const auto at = [&](double z) { return plan.rear() + 0.5 * plan.rail - plan.Behind(z); };
  const double half = 0.5 * (plan.width - plan.rail);
  for (const double side : kSides)
    solids.Frustum(Material::kFrame,
                   {at(low), side * half, low},
                   {plan.rail, plan.rail},
                   {at(top), side * half, top},
                   {plan.rail, plan.rail});
  if (Chance(random, 0.35)) {
    solids.Board(
        Material::kFrame,
        [&](double u, double h) {
          const double z = plan.seat() + h * (top - plan.seat());
          return Eigen::Vector3d(at(z), u * half, z);
        },
        0.5 * plan.rail,
        5,
        3);
    return;
  }
  const int bars = Count(random, 1, 3);
  for (int n = 0; n < bars; ++n) {
    const double z = top - (top - plan.seat()) * n / bars - 0.5 * plan.rail;
    solids.Box(Material::kFrame, {at(z), 0, z}, {plan.rail, 2 * half, plan.rail});
  }
}

void BackCushions(Random& random, const FramePlan& plan, Solids& solids) {
  const int count = Chance(random, 0.35) ? 1 : plan.places;
  const double roundness = random.Uniform(0.05, 0.4);
  const double low = plan.seat() + random.Uniform(-0.06, 0.03);
  const double middle = 0.5 * (low + plan.back_top);
  const double width = plan.width / count;
  for (int n = 0; n < count; ++n)
    solids.Cushion(Material::kTop,
                   {plan.rear() + 0.4 * plan.rail + 0.5 * plan.back - plan.Behind(middle),
                    width * (n + 0.5) - 0.5 * plan.width,
                    middle},
                   {plan.back, width - 0.008, plan.back_top - low},
                   roundness,
                   0.15,
                   Leaning(plan.lean));
}

struct ArmPlan {
  double low = 0;
  double top = 0;
  double front = 0;
  double rear = 0;
  double y = 0;

  [[nodiscard]] double middle() const { return 0.5 * (front + rear); }
  [[nodiscard]] double length() const { return front - rear; }
};

// What a frame from floor to arm and down again is made of.
struct Bars {
  double rail = 0;
  double width = 0;  // of flat ones
  double splay = 0;  // how much farther apart they stand on the floor
  double bend = 0;   // of round ones
};

void RoundFrame(const ArmPlan& arm, const Bars& bars, double y, Solids& solids) {
  solids.Tube(Material::kFrame,
              {{arm.rear - bars.splay, y, 0},
               {arm.rear, y, arm.top - bars.bend},
               {arm.rear + bars.bend, y, arm.top},
               {arm.front - bars.bend, y, arm.top},
               {arm.front, y, arm.top - bars.bend},
               {arm.front + bars.splay, y, 0}},
              0.5 * bars.rail,
              0.5 * bars.rail,
              10);
}

void FlatFrame(const ArmPlan& arm, const Bars& bars, double y, Solids& solids) {
  const Eigen::Vector2d bar(bars.rail, bars.width);
  for (const double end : kSides) {
    const double x = end > 0 ? arm.front : arm.rear;
    solids.Frustum(Material::kFrame, {x + end * bars.splay, y, 0}, bar, {x, y, arm.top}, bar);
  }
  solids.Box(Material::kFrame,
             {arm.middle(), y, arm.top},
             {arm.length() + bars.rail, bars.width, bars.rail});
}

// At both ends; they carry the sofa.
void ArmFrames(Random& random, const ArmPlan& arm, double rail, Solids& solids) {
  Bars bars;
  bars.rail = rail;
  bars.splay = Chance(random, 0.3) ? random.Uniform(0.02, 0.1) : 0.0;
  const bool round = Chance(random, 0.5);
  const bool closed = Chance(random, 0.3);  // runs along the floor as well
  bars.width = round ? rail : random.Uniform(0.03, 0.08);
  bars.bend = random.Uniform(0.03, 0.1);
  for (const double side : kSides) {
    const double y = side * arm.y;
    if (round) {
      RoundFrame(arm, bars, y, solids);
    } else {
      FlatFrame(arm, bars, y, solids);
    }
    if (closed)
      solids.Box(Material::kFrame,
                 {arm.middle(), y, 0.5 * rail},
                 {arm.length() + 2 * bars.splay, bars.width, rail});
    // What the deck rests on.
    solids.Box(Material::kFrame,
               {arm.middle(), y - side * 0.01, arm.low},
               {arm.length(), rail + 0.02, rail});
  }
}

// Panels or cushions between deck and arm.
void ArmPanels(Random& random, const ArmPlan& arm, double low, double thickness, Solids& solids) {
  const double roundness = Chance(random, 0.5) ? 0.05 : random.Uniform(0.1, 0.4);
  for (const double side : kSides)
    solids.Cushion(Material::kBody,
                   {arm.middle(), side * arm.y, 0.5 * (low + arm.top)},
                   {arm.length(), thickness, arm.top - low},
                   roundness,
                   0.15);
}

// Arms, and what carries the sofa: frames at both ends, or legs below the deck; panels with either.
void EndsOf(Random& random, const FramePlan& plan, Solids& solids) {
  const bool framed = Chance(random, 0.45);
  const bool panelled = Chance(random, 0.5);
  ArmPlan arm;
  arm.low = plan.deck - 0.5 * plan.rail - 0.01;
  arm.top = Chance(random, 0.25) ? plan.back_top : plan.seat() + random.Uniform(0.08, 0.28);
  arm.rear = plan.rear() + random.Uniform(-0.06, 0.08);
  arm.front = 0.5 * plan.depth - random.Uniform(-0.04, 0.14);
  arm.y = 0.5 * (plan.width + plan.rail) - 0.005;
  if (framed) {
    ArmFrames(random, arm, plan.rail, solids);
  } else {
    const Footing footing = {{plan.depth, plan.width}, plan.deck - 0.01, random.Uniform(0.0, 0.12)};
    if (Chance(random, 0.8)) {
      FourLegs(random, footing, solids);
    } else {
      Sledges(random, footing, solids);
    }
  }
  if (!panelled) return;
  const double thickness = random.Uniform(0.03, 0.18);
  arm.y +=
      framed ? -0.45 * thickness : 0.5 * thickness - plan.rail;  // within frames, or at the deck
  const double below = framed ? 0.01 : random.Uniform(0.0, 0.1);
  ArmPanels(random, arm, plan.deck - below, thickness, solids);
}

}  // namespace

void BuildFramedSofa(Random& random, Solids& solids) {
  const FramePlan plan = DrawFrame(random);
  Deck(random, plan, solids);
  SeatCushions(random, plan, solids);
  const bool cushions = Chance(random, 0.85);
  const double frame_top =
      cushions ? plan.seat() + random.Uniform(0.5, 1.05) * (plan.back_top - plan.seat())
               : plan.back_top;
  BackFrame(random, plan, frame_top, solids);
  if (cushions) BackCushions(random, plan, solids);
  EndsOf(random, plan, solids);
}

}  // namespace deepslam::furniture
