// Chairs, stools, office chairs, armchairs.
#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/seats.h"
#include "deepslam/furniture/supports.h"

namespace deepslam::furniture {
namespace {

Seat DrawSeat(Random& random) {
  Seat seat;
  seat.width = random.Uniform(0.36, 0.56);
  seat.depth = random.Uniform(0.36, 0.54);
  seat.height = random.Uniform(0.4, 0.5);
  seat.thickness = random.Uniform(0.018, 0.06);
  return seat;
}

}  // namespace

void SeatBoard(Random& random, Seat& seat, Solids& solids) {
  const std::size_t kind = Pick(random, std::array{1.0, 1.0, 1.0, 0.5});
  const Eigen::Vector3d size(seat.depth, seat.width, seat.thickness);
  const Eigen::Vector3d middle(0, 0, seat.height - 0.5 * seat.thickness);
  if (kind == 0) {
    solids.Box(Material::kTop, middle, size);
  } else if (kind == 1) {
    const double roundness = random.Uniform(0.15, 0.8);
    seat.corner = CornerShare(roundness);
    solids.Plate(Material::kTop, middle, size, roundness);
  } else if (kind == 2) {
    seat.thickness = random.Uniform(0.05, 0.13);
    solids.Cushion(Material::kTop,
                   {0, 0, seat.height - 0.5 * seat.thickness},
                   {seat.depth, seat.width, seat.thickness},
                   random.Uniform(0.3, 0.6),
                   random.Uniform(0.15, 0.5));
  } else {
    // Wider in front than behind, and hollow: a shell of plywood or plastic.
    const double sink = random.Uniform(0.0, 0.03);
    const double narrow = random.Uniform(0.75, 1.0);
    const Seat s = seat;
    std::vector<Solids::Ring> rings;
    constexpr int kPanRings = 7;  // rings of the pan from front to back: its hollow bends smoothly
    for (int n = 0; n < kPanRings; ++n) {
      const double t = static_cast<double>(n) / (kPanRings - 1);
      const double half = 0.5 * s.width * (narrow + (1 - narrow) * t);
      const double x = (t - 0.5) * s.depth;
      const double drop = sink * std::sin(3.1416 * t) + (t > 0.85 ? 0.4 * sink : 0);
      const double top = s.height - drop;
      rings.push_back({{x, -half, top},
                       {x, 0, top - 0.5 * sink},
                       {x, half, top},
                       {x, half, top - s.thickness},
                       {x, 0, top - s.thickness - 0.5 * sink},
                       {x, -half, top - s.thickness}});
    }
    solids.Loft(Material::kTop, rings);
  }
}

namespace {

// The surface of a back: from height `low` to `high`, leaning and curved.
struct Back {
  double x = 0;  // of its middle at the seat's height
  double seat = 0;
  double half_width = 0;
  double lean = 0;   // backward per height
  double curve = 0;  // how far its sides come forward of its middle
  double bow = 0;    // backward bend over its height
  double flare = 0;  // wider above
  double low = 0;
  double high = 0;
  double arch = 0;  // rise of the middle of its upper edge

  [[nodiscard]] Eigen::Vector3d At(double u, double z) const {
    const double rise = std::max(0.0, z - seat);
    const double span = std::max(0.05, high - seat);
    const double t = rise / span;
    return {x - lean * rise - bow * t * t + curve * (u * u - 0.5) * std::min(1.0, 2 * t),
            u * half_width * (1 + flare * t),
            z};
  }
};

Back DrawBack(Random& random, const Seat& seat) {
  Back back;
  back.seat = seat.height;
  back.half_width = 0.5 * seat.width * seat.corner * random.Uniform(0.8, 1.02);
  back.lean = random.Uniform(0.0, 0.25);
  back.curve = Chance(random, 0.5) ? random.Uniform(0.0, 0.14) : 0.0;
  back.bow = Chance(random, 0.3) ? random.Uniform(0.0, 0.08) : 0.0;
  back.flare = Chance(random, 0.3) ? random.Uniform(-0.25, 0.15) : 0.0;
  const double height = Chance(random, 0.8) ? random.Uniform(0.3, 0.58) : random.Uniform(0.14, 0.3);
  back.low = seat.height;
  back.high = seat.height + height;
  back.arch = Chance(random, 0.35) ? random.Uniform(0.0, 0.07) : 0.0;
  return back;
}

void Panel(const Back& back,
           Material material,
           double low,
           double high,
           double thickness,
           double from_u,
           double to_u,
           double arch,
           Solids& solids) {
  solids.Board(
      material,
      [&](double u, double h) {
        const double v = from_u + 0.5 * (u + 1) * (to_u - from_u);
        const double z = low + h * (high - low) + (h > 0.99 ? arch * (1 - v * v) : 0.0);
        return back.At(v, z);
      },
      thickness,
      to_u - from_u > 0.5 ? 9 : 2,
      high - low > 0.12 ? 5 : 2);
}

// Posts at both sides, or one in the middle, from `from_z` up.
void Posts(Random& random, const Back& back, double from_z, double to_z, bool one, Solids& solids) {
  const double thickness = random.Uniform(0.022, 0.048);
  const bool round = Chance(random, 0.4);
  for (const double side : kSides) {
    if (one && side > 0) break;
    const double u = one ? 0.0 : side * (1 - thickness / back.half_width);
    const double width = one ? 2.2 * thickness : thickness;
    std::vector<Solids::Ring> rings;
    std::vector<Eigen::Vector3d> line;
    constexpr int kPostRings = 5;  // rings of a post: the back's curve is slight
    for (int n = 0; n < kPostRings; ++n) {
      const double z = from_z + (to_z - from_z) * n / (kPostRings - 1);
      const Eigen::Vector3d p = back.At(u, z);
      line.push_back(p);
      rings.push_back({p + Eigen::Vector3d(-0.5 * thickness, -0.5 * width, 0),
                       p + Eigen::Vector3d(0.5 * thickness, -0.5 * width, 0),
                       p + Eigen::Vector3d(0.5 * thickness, 0.5 * width, 0),
                       p + Eigen::Vector3d(-0.5 * thickness, 0.5 * width, 0)});
    }
    if (round) {
      solids.Tube(Material::kFrame, line, 0.5 * thickness, 0.42 * thickness);
    } else {
      solids.Loft(Material::kFrame, rings);
    }
  }
}

void HorizontalSlats(Random& random, const Back& back, double thickness, Solids& solids) {
  const int count = Count(random, 1, 5);
  const double span = (back.high - back.seat) * random.Uniform(0.5, 0.95);
  const double pitch = span / count;
  const double height = pitch * random.Uniform(0.3, 0.75);
  for (int n = 0; n < count; ++n) {
    const double top = back.high - pitch * n;
    Panel(
        back, Material::kBody, top - height, top, thickness, -1, 1, n == 0 ? back.arch : 0, solids);
  }
}

void UprightSlats(Random& random, const Back& back, double thickness, Solids& solids) {
  const double rail = random.Uniform(0.03, 0.1);
  Panel(back, Material::kBody, back.high - rail, back.high, thickness, -1, 1, back.arch, solids);
  const double low =
      Chance(random, 0.5) ? back.seat + random.Uniform(0.02, 0.12) : back.seat - 0.01;
  if (low > back.seat)
    Panel(
        back, Material::kBody, low, low + random.Uniform(0.02, 0.05), thickness, -1, 1, 0, solids);
  const int count = Count(random, 1, 8);
  const bool spindles = Chance(random, 0.4);
  const double half = random.Uniform(0.012, 0.36 / count);
  for (int n = 0; n < count; ++n) {
    const double u = 2.0 * (n + 1) / (count + 1) - 1;
    const double high = back.high - 0.5 * rail;
    if (spindles) {
      solids.Tube(Material::kBody,
                  {back.At(u, low), back.At(u, 0.5 * (low + high)), back.At(u, high)},
                  0.009,
                  0.007,
                  6);
    } else {
      Panel(back, Material::kBody, low, high, 0.6 * thickness, u - half, u + half, 0, solids);
    }
  }
}

void CrossedBack(Random& random, const Back& back, double thickness, Solids& solids) {
  const double rail = random.Uniform(0.03, 0.07);
  Panel(back, Material::kBody, back.high - rail, back.high, thickness, -1, 1, back.arch, solids);
  const double low = back.seat + random.Uniform(0.0, 0.1);
  Panel(back, Material::kBody, low, low + 0.03, thickness, -1, 1, 0, solids);
  const double high = back.high - 0.5 * rail;
  for (const double side : kSides) {
    solids.Tube(
        Material::kBody,
        {back.At(-0.9 * side, low), back.At(0, 0.5 * (low + high)), back.At(0.9 * side, high)},
        0.5 * thickness + 0.004,
        0.5 * thickness + 0.004,
        6);
  }
}

// Hoop of bent wood or tube with a filling.
void HoopBack(Random& random, const Back& back, Solids& solids) {
  const double r = random.Uniform(0.009, 0.02);
  std::vector<Eigen::Vector3d> line;
  constexpr int kHoopPoints = 11;  // points of the half circle, 18 deg apart
  for (int n = 0; n < kHoopPoints; ++n) {
    const double angle = 3.14159265 * n / (kHoopPoints - 1);
    const double u = std::cos(angle);
    const double z = back.seat - 0.01 + (back.high - back.seat) * std::pow(std::sin(angle), 0.6);
    line.push_back(back.At(u, z));
  }
  solids.Tube(Material::kFrame, line, r, r);
  const int spindles = Count(random, 0, 6);
  for (int n = 0; n < spindles; ++n) {
    const double u = 2.0 * (n + 1) / (spindles + 1) - 1;
    const double top =
        back.seat + (back.high - back.seat) * std::pow(std::max(0.0, 1 - u * u), 0.3);
    solids.Tube(Material::kBody, {back.At(u, back.seat - 0.01), back.At(u, top)}, 0.008, 0.007, 6);
  }
  if (spindles == 0)
    Panel(back,
          Material::kBody,
          back.seat + 0.3 * (back.high - back.seat),
          back.seat + 0.75 * (back.high - back.seat),
          0.015,
          -0.9,
          0.9,
          0,
          solids);
}

void PaddedBack(Random& random, const Back& back, double low, Solids& solids) {
  const double thickness = random.Uniform(0.05, 0.13);
  const Eigen::Vector3d middle = back.At(0, 0.5 * (low + back.high));
  solids.Cushion(Material::kBody,
                 middle + Eigen::Vector3d(0.3 * thickness, 0, 0),
                 {thickness, 2 * back.half_width, back.high - low},
                 random.Uniform(0.2, 0.5),
                 random.Uniform(0.2, 0.6),
                 [&](const Eigen::Vector3d& p) {
                   return Eigen::Vector3d(
                       p.x() - back.lean * p.z() + back.curve * p.y() * p.y(), p.y(), p.z());
                 });
}

enum BackStyle : std::size_t { kSolid, kSlats, kUpright, kPadded, kFrameBack, kCrossed, kHoop };

}  // namespace

void SeatBack(Random& random, const Seat& seat, bool on_column, Solids& solids) {
  Back back = DrawBack(random, seat);
  const auto style = static_cast<BackStyle>(
      on_column ? Pick(random, std::array{1.0, 0.15, 0.1, 1.2, 0.3})
                : Pick(random, std::array{1.3, 1.2, 1.0, 0.6, 0.5, 0.35, 0.4}));
  const double thickness = random.Uniform(0.014, 0.04);
  back.x = -0.5 * seat.depth * seat.corner + 0.5 * thickness + random.Uniform(0, 0.02);
  if (style == kHoop) {
    back.curve = std::max(back.curve, 0.02);
    HoopBack(random, back, solids);
    return;
  }
  const bool gap = (style == kSolid || style == kPadded) && Chance(random, 0.45);
  // Without a gap it begins within the seat, whose rim may be rounded.
  const double low = gap ? back.seat + random.Uniform(0.05, 0.5 * (back.high - back.seat))
                         : back.seat - std::max(0.01, 0.5 * seat.thickness);
  const bool posts =
      gap || style == kSlats || style == kUpright || style == kFrameBack || style == kCrossed;
  if (posts) {
    const bool one = on_column && Chance(random, 0.7);
    const double top = gap ? back.high - 0.25 * (back.high - low) : back.high - 0.005;
    Posts(random, back, seat.height - seat.thickness, top, one, solids);
  }
  switch (style) {
    case kSolid:
      Panel(back, Material::kBody, low, back.high, thickness, -1, 1, back.arch, solids);
      break;
    case kSlats:
      HorizontalSlats(random, back, 0.7 * thickness, solids);
      break;
    case kUpright:
      UprightSlats(random, back, thickness, solids);
      break;
    case kPadded:
      PaddedBack(random, back, low, solids);
      break;
    case kFrameBack:
      Panel(back,
            Material::kBody,
            back.high - random.Uniform(0.04, 0.16),
            back.high,
            thickness,
            -1,
            1,
            back.arch,
            solids);
      break;
    case kCrossed:
      CrossedBack(random, back, thickness, solids);
      break;
    case kHoop:
      break;
  }
}

void SeatArms(Random& random, const Seat& seat, double back_lean, Solids& solids) {
  const double height = seat.height + random.Uniform(0.15, 0.27);
  const double width = random.Uniform(0.03, 0.075);
  const double y = 0.5 * seat.width + 0.5 * width - 0.012;
  const double front = seat.depth * random.Uniform(0.12, 0.5);
  const double rear = -0.5 * seat.depth - back_lean * (height - seat.height) + 0.01;
  const double thickness = random.Uniform(0.018, 0.045);
  const std::size_t kind = Pick(random, std::array{1.0, 0.8, 0.6});
  for (const double side : kSides) {
    if (kind == 1) {
      const double r = random.Uniform(0.009, 0.016);
      solids.Tube(Material::kFrame,
                  {{rear + 0.05, side * y, seat.height - seat.thickness},
                   {rear + 0.04, side * y, height - 0.03},
                   {rear + 0.07, side * y, height},
                   {front - 0.03, side * y, height},
                   {front, side * y, height - 0.03},
                   {front - 0.03, side * y, seat.height - seat.thickness}},
                  r,
                  r);
      continue;
    }
    solids.Box(Material::kFrame,
               {0.5 * (rear + front), side * y, height},
               {front - rear, width, thickness});
    // On a post in front, or in the middle.
    const double x = kind == 0 ? front - 0.045 : 0.0;
    const double thick = kind == 0 ? 0.035 : 0.06;
    solids.Frustum(
        Material::kFrame,
        {x, side * (0.5 * seat.width * seat.corner - 0.014), seat.height - seat.thickness},
        {thick, 0.03},
        {x, side * y, height},
        {thick, 0.03});
  }
}

void BuildChair(Random& random, Solids& solids) {
  Seat seat = DrawSeat(random);
  SeatBoard(random, seat, solids);
  const double underside = seat.height - seat.thickness + 0.008;
  const Footing footing = {
      seat.corner * Eigen::Vector2d(seat.depth, seat.width), underside, random.Uniform(0.0, 0.04)};
  const std::size_t base = Pick(random, std::array{1.0, 0.14, 0.05});
  if (base == 0) {
    FourLegs(random, footing, solids);
  } else if (base == 1) {
    Sledges(random, footing, solids);
  } else {
    Pedestal(random, underside, random.Uniform(0.18, 0.27), solids);
  }
  SeatBack(random, seat, false, solids);
  if (Chance(random, 0.25)) SeatArms(random, seat, 0.1, solids);
}

void BuildStool(Random& random, Solids& solids) {
  Seat seat;
  seat.width = random.Uniform(0.28, 0.46);
  seat.depth = Chance(random, 0.6) ? seat.width : seat.width * random.Uniform(0.65, 1.0);
  seat.height = Chance(random, 0.6) ? random.Uniform(0.38, 0.52) : random.Uniform(0.58, 0.8);
  seat.thickness = random.Uniform(0.02, 0.07);
  const std::size_t top = Pick(random, std::array{1.0, 0.7, 0.6});
  const Eigen::Vector3d size(seat.depth, seat.width, seat.thickness);
  const Eigen::Vector3d middle(0, 0, seat.height - 0.5 * seat.thickness);
  if (top == 0) solids.Plate(Material::kTop, middle, size, 1.0);
  if (top == 1) solids.Box(Material::kTop, middle, size);
  if (top == 2) solids.Cushion(Material::kTop, middle, size, 0.5, random.Uniform(0.3, 1.0));
  const double underside = seat.height - seat.thickness + 0.008;
  const double round = top == 1 ? 1.0 : CornerShare(1.0);
  const std::size_t base = Pick(random, std::array{1.0, 0.2, 0.25});
  if (base == 0) {
    FourLegs(random, {round * Eigen::Vector2d(seat.depth, seat.width), underside, 0.01}, solids);
  } else if (base == 1) {
    Star(random, underside, random.Uniform(0.2, 0.3), solids);
  } else {
    Pedestal(random, underside, random.Uniform(0.17, 0.24), solids);
    if (seat.height > 0.58) {
      solids.Turned(Material::kDetail, {0, 0, 0.28 * seat.height}, {{0.15, 0}, {0.15, 0.016}}, 16);
    }
  }
}

void BuildOfficeChair(Random& random, Solids& solids) {
  Seat seat = DrawSeat(random);
  seat.width = random.Uniform(0.42, 0.54);
  seat.depth = random.Uniform(0.42, 0.52);
  seat.height = random.Uniform(0.42, 0.54);
  SeatBoard(random, seat, solids);
  solids.Box(Material::kDetail, {0, 0, seat.height - seat.thickness - 0.015}, {0.22, 0.16, 0.05});
  Star(random, seat.height - seat.thickness, random.Uniform(0.25, 0.34), solids);
  SeatBack(random, seat, true, solids);
  if (Chance(random, 0.6)) SeatArms(random, seat, 0.1, solids);
}

void BuildArmchair(Random& random, Solids& solids) {
  Seat seat;
  seat.width = random.Uniform(0.48, 0.66);
  seat.depth = random.Uniform(0.5, 0.66);
  seat.height = random.Uniform(0.36, 0.46);
  const double arm = random.Uniform(0.06, 0.18);
  const double arm_height = seat.height + random.Uniform(0.08, 0.24);
  const double back = random.Uniform(0.1, 0.22);
  const double back_height = seat.height + random.Uniform(0.3, 0.6);
  const double feet = random.Uniform(0.02, 0.16);
  const double lean = random.Uniform(0.0, 0.2);
  const double width = seat.width + 2 * arm;
  const double cushion = random.Uniform(0.1, 0.18);
  solids.Box(Material::kBody,
             {0, 0, 0.5 * (feet + seat.height - 0.5 * cushion)},
             {seat.depth, width - 0.02, seat.height - 0.5 * cushion - feet});
  solids.Cushion(Material::kTop,
                 {0.02, 0, seat.height - 0.5 * cushion},
                 {seat.depth, seat.width, cushion},
                 random.Uniform(0.25, 0.5),
                 random.Uniform(0.15, 0.35));
  const double back_low = feet + 0.02;
  solids.Cushion(Material::kBody,
                 {-0.5 * seat.depth, 0, 0.5 * (back_low + back_height)},
                 {back, Chance(random, 0.5) ? width : seat.width, back_height - back_low},
                 random.Uniform(0.15, 0.45),
                 random.Uniform(0.15, 0.5),
                 Leaning(lean));
  const bool soft = Chance(random, 0.5);
  const bool open = !soft && Chance(random, 0.35);
  for (const double side : kSides) {
    const double y = side * 0.5 * (seat.width + arm);
    const Eigen::Vector3d middle(0.0, y, 0.5 * (feet + arm_height));
    const Eigen::Vector3d size(seat.depth, arm, arm_height - feet);
    if (open) {
      solids.Box(Material::kFrame, {0, y, arm_height}, {seat.depth, 0.6 * arm, 0.035});
      for (const double end : kSides)
        solids.Box(Material::kFrame,
                   {end * 0.45 * seat.depth, y, 0.5 * arm_height},
                   {0.04, 0.04, arm_height});
    } else if (soft) {
      solids.Cushion(Material::kBody, middle, size, random.Uniform(0.15, 0.4), 0.2);
    } else {
      solids.Box(Material::kBody, middle, size);
    }
  }
  Feet(random, {{seat.depth, width}, feet, 0.02}, solids);
}

}  // namespace deepslam::furniture
