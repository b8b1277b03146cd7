#include "deepslam/priors/training_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "deepslam/core/angles.h"
#include "deepslam/core/wide_vectors.h"
#include "deepslam/priors/raster.h"
#include "deepslam/priors/segment_faults.h"
#include "deepslam/priors/surface_look.h"
#include "deepslam/render/ray_scene.h"
#include "deepslam/render/shaded_view.h"
#include "deepslam/scene/mesh_box.h"

namespace deepslam::priors {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFocal_px = 525;  // of a 640 x 480 camera
// Along the longer side, more detail than the crop keeps: of the whole object, and where a part of
// it will fill the crop.
constexpr double kMostPixels = 128;
// The part alone then has about as many as a whole object.
constexpr double kMostPixelsForPart = 190;
constexpr double kPartViewShare = 0.15;  // of the views with faults
constexpr double kLeastVisible = 0.12;   // of the object, or another view is drawn
constexpr int kMostTries = 12;  // draws of a view before it is taken as it is, without faults

struct Viewpoint {
  Pose3 object_from_camera;
  double azimuth_rad = 0;
  double elevation_rad = 0;
  double distance_m = 0;
};

// A person or a robot with a camera: distance by the object's size, lens between knee and raised
// arm.
Viewpoint DrawViewpoint(Random& random, const Eigen::Vector3d& size_m, bool faults) {
  const double longest_m = size_m.maxCoeff();
  Viewpoint viewpoint;
  viewpoint.azimuth_rad = random.Uniform(-kPi, kPi);
  viewpoint.distance_m = random.Uniform(0.7 + 0.6 * longest_m, 2.4 + 0.8 * longest_m);
  const double lens_m = random.Uniform(0.5, 1.9);
  const double rise = std::clamp((lens_m - 0.5 * size_m.z()) / viewpoint.distance_m, -0.35, 0.8);
  viewpoint.elevation_rad = std::asin(rise);
  const double level = std::cos(viewpoint.elevation_rad);
  const Eigen::Vector3d position =
      viewpoint.distance_m * Eigen::Vector3d(level * std::cos(viewpoint.azimuth_rad),
                                             level * std::sin(viewpoint.azimuth_rad),
                                             std::sin(viewpoint.elevation_rad));
  const auto aside = [&] { return 0.2 * random.Uniform(-1, 1); };
  const Eigen::Vector3d target = Eigen::Vector3d(aside(), aside(), aside()).cwiseProduct(size_m);
  viewpoint.object_from_camera = render::LookAt(position, target);
  const double roll_rad = faults ? 5.0 * kRadPerDeg * std::clamp(random.Normal(), -2.5, 2.5) : 0.0;
  viewpoint.object_from_camera.rotation =
      viewpoint.object_from_camera.rotation *
      Eigen::Quaterniond(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return viewpoint;
}

// The camera cut to the object's box on the image, and made coarser where that holds more pixels
// than are of use.
PinholeCamera FrameObject(const std::vector<Eigen::Vector3f>& outline,
                          const Pose3& camera_from_object,
                          double most_pixels) {
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const Eigen::Vector3f& vertex : outline) {
    const Eigen::Vector3d p = camera_from_object * vertex.cast<double>();
    const Eigen::Vector2d at = p.head<2>() / std::max(0.1, p.z());
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const double focal_px = std::min(kFocal_px, most_pixels / (high - low).maxCoeff());
  constexpr double kRim_px = 4;  // of background round the object
  const Eigen::Vector2d size = (focal_px * (high - low)).array().ceil() + 2 * kRim_px;
  PinholeCamera camera;
  camera.width = static_cast<int>(size.x());
  camera.height = static_cast<int>(size.y());
  camera.fx = camera.fy = focal_px;
  camera.cx = kRim_px - focal_px * low.x();
  camera.cy = kRim_px - focal_px * low.y();
  return camera;
}

// Unit, object frame.
DEEPSLAM_WIDE_VECTORS
void FillRays(const PinholeCamera& camera,
              const Eigen::Matrix3f& object_from_camera,
              Image<Eigen::Vector3f>& rays) {
  const auto per_u = static_cast<float>(1 / camera.fx);
  const auto cx = static_cast<float>(camera.cx);
  const Eigen::Vector3f across = object_from_camera.col(0);
  for (int v = 0; v < rays.height(); ++v) {
    const auto y = static_cast<float>((v - camera.cy) / camera.fy);
    const Eigen::Vector3f row = object_from_camera.col(2) + y * object_from_camera.col(1);
    for (int u = 0; u < rays.width(); ++u) {
      const float x = (static_cast<float>(u) - cx) * per_u;
      const float scale = 1 / std::sqrt(1 + x * x + y * y);
      rays(u, v) = scale * (row + x * across);
    }
  }
}

void CastRays(const render::RayScene& scene, Raster& raster) {
  const Eigen::Vector3f origin = raster.object_from_camera.translation_m.cast<float>();
  const Eigen::Matrix3f turn = raster.object_from_camera.rotation.toRotationMatrix().cast<float>();
  FillRays(raster.camera, turn, raster.rays);
  const Eigen::Vector3f axis = turn.col(2);
  const auto width = static_cast<std::size_t>(raster.width());
  for (int v = 0; v < raster.height(); ++v) {
    scene.CastFan(origin, {raster.rays.row(v), width}, {raster.hits.row(v), width});
    for (int u = 0; u < raster.width(); ++u) {
      const render::RayHit& hit = raster.hits(u, v);
      if (hit.instance < 0) continue;
      raster.true_depth_m(u, v) = static_cast<float>(hit.distance_m) * axis.dot(raster.rays(u, v));
    }
  }
}

Raster MakeRaster(const render::RayScene& scene,
                  const std::vector<Eigen::Vector3f>& outline,
                  const Viewpoint& viewpoint,
                  double bottom_m,
                  double most_pixels) {
  Raster raster;
  raster.object_from_camera = viewpoint.object_from_camera;
  const Pose3 camera_from_object = viewpoint.object_from_camera.Inverse();
  raster.camera = FrameObject(outline, camera_from_object, most_pixels);
  raster.ground_camera = Transformed(camera_from_object, {Eigen::Vector3d::UnitZ(), -bottom_m});
  const int w = raster.camera.width;
  const int h = raster.camera.height;
  raster.rays = Image<Eigen::Vector3f>(w, h, Eigen::Vector3f::Zero());
  raster.hits = Image<render::RayHit>(w, h);
  raster.true_depth_m = DepthImage(w, h);
  raster.colour = Image<Eigen::Vector3f>(w, h, Eigen::Vector3f::Ones());
  CastRays(scene, raster);
  return raster;
}

// Of a value that is not negative, as lround but a call less.
std::uint8_t Rounded(float value) { return static_cast<std::uint8_t>(value + 0.5F); }

ObjectView ToObjectView(const Raster& raster) {
  ObjectView view;
  view.colour_crop = ColourImage(raster.width(), raster.height());
  for (std::size_t n = 0; n < view.colour_crop.size(); ++n) {
    if (raster.mask.data()[n] == 0) continue;  // the crop is white there
    const Eigen::Vector3f shade = 255.0F * raster.colour.data()[n];
    view.colour_crop.data()[n] = {Rounded(shade.x()), Rounded(shade.y()), Rounded(shade.z())};
  }
  view.depth_crop_m = raster.depth_m;
  view.mask_crop = raster.mask;
  view.camera = raster.camera;
  view.ground_camera = raster.ground_camera;
  return view;
}

// The ground as a capture tells it.
Plane MeasuredGround(Random& random, const Plane& ground_camera) {
  // 0.7 deg, one standard deviation: error of a measured ground.
  constexpr double kTilt_rad = 0.7 * kRadPerDeg;
  constexpr double kHeight_m = 0.01;  // one standard deviation
  const auto off = [&random] { return std::clamp(random.Normal(), -2.5, 2.5); };
  const Eigen::Vector3d tilt = kTilt_rad * Eigen::Vector3d(off(), off(), off());
  return {(ground_camera.normal + tilt).normalized(), ground_camera.d_m + kHeight_m * off()};
}

std::uint8_t NormalByte(float n) { return Rounded(128.0F + 127.0F * n); }

Sketch MakeSketch(const Raster& raster, const propose::NetworkCrop& crop) {
  Sketch sketch{Image<std::uint8_t>(kSketchSide, kSketchSide),
                ColourImage(kSketchSide, kSketchSide, {128, 128, 128}),
                Image<std::uint8_t>(kSketchSide, kSketchSide)};
  const Eigen::Matrix3f crop_from_object =
      (crop.camera.view_from_crop.transpose() *
       raster.object_from_camera.rotation.toRotationMatrix().transpose())
          .cast<float>();
  for (int y = 0; y < kSketchSide; ++y) {
    const double down = (y + 0.5) / kSketchSide;
    const Eigen::Vector3d first = crop.camera.RayAt(0.5 / kSketchSide, down);
    const Eigen::Vector3d step = crop.camera.RayAt(1.5 / kSketchSide, down) - first;
    for (int x = 0; x < kSketchSide; ++x) {
      const std::optional<Eigen::Vector2d> pixel = raster.camera.Project(first + x * step);
      if (!pixel) continue;
      const auto u = static_cast<int>(std::floor(pixel->x() + 0.5));
      const auto v = static_cast<int>(std::floor(pixel->y() + 0.5));
      if (!raster.hits.Contains(u, v) || raster.hits(u, v).instance < 0) continue;
      const Eigen::Vector3f n = crop_from_object * raster.hits(u, v).normal_world;
      sketch.normal(x, y) = {NormalByte(n.x()), NormalByte(n.y()), NormalByte(n.z())};
      sketch.silhouette(x, y) = 255;
      if (crop.side_m <= 0) continue;
      const double depth_m =
          crop.camera.DepthOf(raster.camera.Unproject(u, v, raster.true_depth_m(u, v)));
      const double relative = (depth_m - crop.reference_m) / crop.side_m;
      sketch.depth(x, y) =
          Rounded(std::clamp(static_cast<float>(128 + 127 * relative), 1.0F, 255.0F));
    }
  }
  return sketch;
}

Left DrawLeft(Random& random, const ViewOptions& options) {
  if (options.top_share > 0 && random.Uniform() < options.top_share) return Left::kTop;
  return random.Uniform() < kPartViewShare ? Left::kPart : Left::kWhole;
}

double VisibleShare(const Raster& raster) {
  std::size_t kept = 0;
  std::size_t all = 0;
  for (std::size_t n = 0; n < raster.mask.size(); ++n) {
    if (raster.true_depth_m.data()[n] <= 0) continue;
    ++all;
    kept += raster.mask.data()[n] != 0 ? 1 : 0;
  }
  return all == 0 ? 0.0 : static_cast<double>(kept) / static_cast<double>(all);
}

}  // namespace

struct ViewRenderer::Impl {
  FurnitureMesh furniture;
  render::RayScene scene;
  std::vector<Eigen::Vector3f> outline;  // enough vertices to bound it on images
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  double bottom_m = 0;
};

ViewRenderer::ViewRenderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ViewRenderer::~ViewRenderer() = default;
ViewRenderer::ViewRenderer(ViewRenderer&&) noexcept = default;
ViewRenderer& ViewRenderer::operator=(ViewRenderer&&) noexcept = default;

Result<ViewRenderer> ViewRenderer::Make(FurnitureMesh furniture) {
  auto impl = std::make_unique<Impl>();
  const TriangleMesh& mesh = furniture.mesh;
  if (!furniture.material_of_face.empty() &&
      furniture.material_of_face.size() != mesh.faces.size()) {
    return InvalidInput("a material for each face, or none");
  }
  if (!mesh.colours.empty() && mesh.colours.size() != mesh.vertices.size())
    return InvalidInput("a colour for each vertex, or none");
  const Result<int> added = impl->scene.AddMesh(mesh, Pose3());
  if (!added) return added.error();
  impl->scene.Commit();
  const Eigen::AlignedBox3f box = BoxOfFaces(mesh);
  impl->size_m = box.sizes().cast<double>();
  impl->bottom_m = box.min().z();
  constexpr std::size_t kMostOutline = 4000;  // vertices that frame the view; of more, every n-th
  const std::size_t step = mesh.vertices.size() / kMostOutline + 1;
  for (std::size_t n = 0; n < mesh.vertices.size(); n += step)
    impl->outline.push_back(mesh.vertices[n].cwiseMax(box.min()).cwiseMin(box.max()));
  impl->furniture = std::move(furniture);
  return ViewRenderer(std::move(impl));
}

TrainingView ViewRenderer::Render(Random random, const ViewOptions& options) const {
  TrainingView view;
  for (int attempt = 0;; ++attempt) {
    // The last attempt always shows something.
    const bool faults = options.faults && attempt + 1 < kMostTries;
    const Viewpoint viewpoint = DrawViewpoint(random, impl_->size_m, options.faults);
    const Left left = faults ? DrawLeft(random, options) : Left::kWhole;
    Raster raster = MakeRaster(impl_->scene,
                               impl_->outline,
                               viewpoint,
                               impl_->bottom_m,
                               left == Left::kWhole ? kMostPixels : kMostPixelsForPart);
    PaintSurfaces(impl_->furniture, impl_->scene, random, raster);
    faults ? SpoilView(random, left, raster) : KeepView(raster);
    const double visible = VisibleShare(raster);
    if (options.faults) raster.ground_camera = MeasuredGround(random, raster.ground_camera);
    Result<propose::NetworkCrop> crop = propose::MakeNetworkCrop(ToObjectView(raster), true);
    if ((visible < kLeastVisible || !crop || crop->side_m <= 0) && attempt + 1 < kMostTries)
      continue;
    DEEPSLAM_CHECK(crop.ok(), "a whole object cannot be cut out");
    view.sketch = MakeSketch(raster, *crop);
    view.crop = std::move(*crop);
    view.azimuth_rad = viewpoint.azimuth_rad;
    view.elevation_rad = viewpoint.elevation_rad;
    view.distance_m = viewpoint.distance_m;
    view.longest_side_m = impl_->size_m.maxCoeff();
    view.visible = visible;
    return view;
  }
}

}  // namespace deepslam::priors
