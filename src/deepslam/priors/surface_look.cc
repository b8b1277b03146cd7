#include "deepslam/priors/surface_look.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "deepslam/core/wide_vectors.h"
#include "deepslam/priors/value_noise.h"

namespace deepslam::priors {
namespace {

constexpr std::size_t kMaterials = 4;  // frame, top, body, detail (furniture/solids.h)

enum class Pattern { kPlain, kStripes, kNoise, kGrain, kChecks };

struct Look {
  Eigen::Vector3f first;
  Eigen::Vector3f second;
  Pattern pattern = Pattern::kPlain;
  float frequency = 10;  // per metre
  int axis = 0;
  float gloss = 0;
};

float Draw(Random& random, double low, double high) {
  return static_cast<float>(random.Uniform(low, high));
}

Eigen::Vector3f DrawColour(Random& random) {
  switch (random.Index(5)) {
    case 0: {  // dark
      const float grey = Draw(random, 0.02, 0.25);
      return {grey * Draw(random, 0.8, 1.2), grey * Draw(random, 0.8, 1.2), grey};
    }
    case 1: {  // grey to white
      const float grey = Draw(random, 0.3, 0.95);
      return {grey, grey * Draw(random, 0.92, 1.05), grey * Draw(random, 0.88, 1.05)};
    }
    case 2: {  // wood
      const float red = Draw(random, 0.25, 0.9);
      return {red, red * Draw(random, 0.55, 0.8), red * Draw(random, 0.25, 0.55)};
    }
    default:
      return {Draw(random, 0, 1), Draw(random, 0, 1), Draw(random, 0, 1)};
  }
}

std::array<Look, kMaterials> DrawLooks(Random& random) {
  std::array<Look, kMaterials> looks;
  const Eigen::Vector3f main = DrawColour(random);
  const bool one = random.Uniform() < 0.35;
  for (std::size_t n = 0; n < kMaterials; ++n) {
    Look& look = looks[n];
    look.first = one || random.Uniform() < 0.35 ? main : DrawColour(random);
    look.second = random.Uniform() < 0.7 ? Eigen::Vector3f(look.first * Draw(random, 0.45, 1.3))
                                         : DrawColour(random);
    constexpr std::array kPatterns = {Pattern::kPlain,
                                      Pattern::kPlain,
                                      Pattern::kStripes,
                                      Pattern::kNoise,
                                      Pattern::kGrain,
                                      Pattern::kGrain,
                                      Pattern::kChecks};
    look.pattern = kPatterns.at(random.Index(kPatterns.size()));
    look.frequency = Draw(random, 4, 40);
    look.axis = static_cast<int>(random.Index(3));
    look.gloss = random.Uniform() < 0.3 ? Draw(random, 0.1, 0.6) : 0.0F;
  }
  return looks;
}

Eigen::Vector3f ColourAt(const Look& look, const Eigen::Vector3f& p) {
  float t = 0;
  switch (look.pattern) {
    case Pattern::kPlain:
      return look.first;
    case Pattern::kStripes:
      t = std::sin(p[look.axis] * look.frequency * 3) > 0 ? 1.0F : 0.0F;
      break;
    case Pattern::kNoise:
      t = ValueNoise(p * look.frequency);
      break;
    case Pattern::kGrain: {
      Eigen::Vector3f q = p * (0.4F * look.frequency);
      q[look.axis] *= 0.1F;
      t = ValueNoise(q * 4.0F);
      break;
    }
    case Pattern::kChecks: {
      const Eigen::Vector3i cell =
          Eigen::Vector3f((p * (0.4F * look.frequency)).array().floor()).cast<int>();
      t = static_cast<float>((cell.x() + cell.y() + cell.z()) & 1);
      break;
    }
  }
  return look.first + t * (look.second - look.first);
}

Eigen::Vector3f OwnColour(const TriangleMesh& mesh, const render::RayHit& hit) {
  const auto& face = mesh.faces[hit.face];
  const std::array weights = {1 - hit.weight_b - hit.weight_c, hit.weight_b, hit.weight_c};
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    const Rgb8& colour = mesh.colours[face[c]];
    sum += weights[c] / 255.0F *
           Eigen::Vector3f(static_cast<float>(colour.r),
                           static_cast<float>(colour.g),
                           static_cast<float>(colour.b));
  }
  // Display values to about linear ones.
  return sum.array().max(0.0F) * sum.array().max(0.0F);
}

struct Light {
  Eigen::Vector3f towards;  // the lamp, unit, object frame
  float sky = 0.4F;
  float lamp = 0.6F;
  bool shadow = false;
  Eigen::Vector3f tint;
  float exposure = 1;
};

Light DrawLight(Random& random) {
  Light light;
  light.towards = Eigen::Vector3f(Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, 0.15, 1.5))
                      .normalized();
  light.sky = Draw(random, 0.25, 0.7);
  light.lamp = Draw(random, 0.3, 0.9);
  light.shadow = random.Uniform() < 0.6;
  light.tint = {Draw(random, 0.85, 1.1), Draw(random, 0.92, 1.06), Draw(random, 0.8, 1.1)};
  light.exposure = Draw(random, 0.6, 1.35);
  return light;
}

// x^20.
float Gloss(float x) {
  const float x4 = x * x * x * x;
  return x4 * x4 * x4 * x4 * x4;
}

// x^gamma for x in [0, 1], by a table over the root of x, along which it is nearly straight.
class GammaCurve {
 public:
  explicit GammaCurve(float gamma) {
    for (std::size_t n = 0; n < values_.size(); ++n)
      values_[n] = std::pow(static_cast<float>(n) / kTableSteps, 2 * gamma);
  }
  float operator()(float x) const {
    const float at = kTableSteps * std::sqrt(x);
    const auto n = std::min(static_cast<std::size_t>(at), values_.size() - 2);
    return values_[n] + (at - static_cast<float>(n)) * (values_[n + 1] - values_[n]);
  }

 private:
  // Lines between so many steps are off by less than a grey level.
  static constexpr int kTableSteps = 128;
  std::array<float, kTableSteps + 1> values_{};
};

}  // namespace

DEEPSLAM_WIDE_VECTORS
void PaintSurfaces(const FurnitureMesh& furniture,
                   const render::RayScene& scene,
                   Random& random,
                   Raster& raster) {
  const std::array<Look, kMaterials> looks = DrawLooks(random);
  const Light light = DrawLight(random);
  const bool own = !furniture.mesh.colours.empty() && random.Uniform() < 0.7;
  const Eigen::Vector3f camera = raster.object_from_camera.translation_m.cast<float>();
  // One shadow ray stands for a block of pixels.
  constexpr int kBlock = 2;
  Image<std::int8_t> lit(raster.width() / kBlock + 1, raster.height() / kBlock + 1, -1);
  const GammaCurve curve(Draw(random, 0.45, 0.75));
  for (int v = 0; v < raster.height(); ++v) {
    for (int u = 0; u < raster.width(); ++u) {
      const render::RayHit& hit = raster.hits(u, v);
      if (hit.instance < 0) continue;
      const Eigen::Vector3f& ray = raster.rays(u, v);
      const Eigen::Vector3f p = camera + static_cast<float>(hit.distance_m) * ray;
      const Eigen::Vector3f& normal = hit.normal_world;
      const std::size_t material =
          furniture.material_of_face.empty() ? 0 : furniture.material_of_face[hit.face];
      const Look& look = looks[std::min(material, kMaterials - 1)];
      const Eigen::Vector3f surface = own ? OwnColour(furniture.mesh, hit) : ColourAt(look, p);
      const float facing = normal.dot(light.towards);
      float lamp = std::max(0.0F, facing);
      if (light.shadow && facing > 0) {
        std::int8_t& seen = lit(u / kBlock, v / kBlock);
        if (seen < 0) {
          const Eigen::Vector3f from = p + 2e-3F * normal;
          seen = scene.Occluded(from, from + 6.0F * light.towards) ? 0 : 1;
        }
        if (seen == 0) lamp *= 0.15F;
      }
      const float bright =
          (light.sky * (0.75F + 0.25F * normal.z()) + light.lamp * lamp) * light.exposure;
      const float gloss =
          lamp > 0.3F * facing && look.gloss > 0 && facing > 0
              ? look.gloss * Gloss(std::max(0.0F, normal.dot((light.towards - ray).normalized())))
              : 0.0F;
      Eigen::Vector3f& colour = raster.colour(u, v);
      colour = surface.cwiseProduct(light.tint) * bright + Eigen::Vector3f::Constant(gloss);
      for (float& c : colour) c = curve(std::clamp(c, 0.0F, 1.0F));
    }
  }
}

}  // namespace deepslam::priors
