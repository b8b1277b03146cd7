#include "deepslam/furniture/proportions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "deepslam/furniture/draw.h"
#include "deepslam/furniture/face_corners.h"
#include "deepslam/scene/mesh_box.h"

namespace deepslam::furniture {

namespace {

constexpr float kLongestEdge = 0.08F;  // of the box's longest side

std::uint8_t Middle(std::uint8_t a, std::uint8_t b) {
  return static_cast<std::uint8_t>((static_cast<int>(a) + static_cast<int>(b)) / 2);
}

Corner Between(const Corner& a, const Corner& b) {
  return {0.5F * (a.place + b.place),
          {Middle(a.colour.r, b.colour.r),
           Middle(a.colour.g, b.colour.g),
           Middle(a.colour.b, b.colour.b)}};
}

// Halved across their longest edges until all are short. An edge is halved for its own length
// alone: neighbours divide what they share alike.
void Divide(const Face& face, float longest, std::vector<Face>& small) {
  std::array<float, 3> lengths{};
  for (std::size_t c = 0; c < 3; ++c) lengths[c] = (face[c].place - face[(c + 1) % 3].place).norm();
  const auto at =
      static_cast<std::size_t>(std::max_element(lengths.begin(), lengths.end()) - lengths.begin());
  if (!(lengths[at] > longest)) {
    small.push_back(face);
    return;
  }
  const Corner& from = face[at];
  const Corner& to = face[(at + 1) % 3];
  const Corner& other = face[(at + 2) % 3];
  const Corner middle = Between(from, to);
  Divide({from, middle, other}, longest, small);
  Divide({middle, to, other}, longest, small);
}

Bend DrawBend(Random& random, double from_low, double from_high, double most) {
  const double from = random.Uniform(from_low, from_high);
  const double to = std::clamp(from + random.Uniform(-most, most), 0.12, 0.88);
  return {static_cast<float>(from), static_cast<float>(to)};
}

// `at` within the box, 0 to 1; as a share of its sides, the box's middle above the origin.
Eigen::Vector3f Bent(const Proportions& proportions, const Eigen::Vector3f& at) {
  const float aside = 2 * at.y() - 1;
  const float up = proportions.height(at.z());
  const float swell = 1 + proportions.taper * (2 * up - 1);
  return {swell * (proportions.depth(at.x()) - 0.5F),
          swell * 0.5F * std::copysign(proportions.width(std::abs(aside)), aside),
          up};
}

}  // namespace

Proportions DrawProportions(bool has_back, Random& random) {
  Proportions drawn;
  for (float& factor : drawn.stretch)
    factor = static_cast<float>(std::exp(random.Uniform(-0.18, 0.18)));
  drawn.depth = DrawBend(random, 0.3, 0.7, 0.1);
  drawn.width = DrawBend(random, 0.5, 0.9, 0.1);
  drawn.height = DrawBend(random, 0.35, 0.6, 0.15);
  if (!has_back) return drawn;
  if (Chance(random, 0.5)) drawn.taper = static_cast<float>(random.Uniform(-0.25, 0.25));
  if (Chance(random, 0.7)) drawn.lean = static_cast<float>(random.Uniform(-0.2, 0.25));
  return drawn;
}

TriangleMesh Reproportion(const TriangleMesh& mesh, const Proportions& proportions) {
  if (mesh.empty()) return {};
  const Eigen::AlignedBox3f box = BoxOfFaces(mesh);
  const Eigen::Vector3f size = box.sizes().cwiseMax(1e-6F);
  std::vector<Face> faces;
  for (const auto& face : mesh.faces)
    Divide(CornersOf(mesh, face), kLongestEdge * size.maxCoeff(), faces);
  const Eigen::Vector3f scale = size.cwiseProduct(proportions.stretch);
  TriangleMesh remade;
  for (Face& face : faces) {
    for (Corner& corner : face) {
      const Eigen::Vector3f bent =
          Bent(proportions, (corner.place - box.min()).cwiseQuotient(size));
      corner.place = bent.cwiseProduct(scale);
      corner.place.x() -=
          proportions.lean * std::max(0.0F, bent.z() - proportions.height.to) * scale.z();
    }
    AddFace(face, remade);
  }
  if (mesh.colours.empty()) remade.colours.clear();
  return remade;
}

}  // namespace deepslam::furniture
