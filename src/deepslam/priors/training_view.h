// Views that shape networks are trained on: one piece of furniture as a depth camera and the
// segmentation of the chain give it, with the truth behind it.
//
// A view is rendered at about the resolution at which a camera would see it, spoilt as cameras and
// segmentation spoil it, and cut out by the function that cuts the views of the chain
// (propose/network_crop.h). Everything random comes from one Random: equal seeds give equal views.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/core/random.h"
#include "deepslam/core/result.h"
#include "deepslam/propose/network_crop.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::priors {

// Metres, object frame (z up, x front), origin at the middle of its box. Colours per vertex are the
// model's own; without them each material gets a look per view.
struct FurnitureMesh {
  TriangleMesh mesh;
  std::vector<std::uint8_t> material_of_face;  // empty: all of one
};

inline constexpr int kSketchSide = 64;  // px

// The whole object behind a crop, in the crop's square, at kSketchSide: as if nothing hid it.
struct Sketch {
  Image<std::uint8_t> depth;  // as NetworkCrop::depth, of the model without noise
  ColourImage normal;         // 128 + 127 n in the crop camera's axes (x right, y down, z forward)
  Image<std::uint8_t> silhouette;  // 255 where the object is
};

struct TrainingView {
  propose::NetworkCrop crop;
  Sketch sketch;
  double azimuth_rad = 0;     // of the camera about the object's z, 0 = in front (+x), (-pi, pi]
  double elevation_rad = 0;   // of the camera above the object's middle
  double distance_m = 0;      // from the camera to the object's middle
  double longest_side_m = 0;  // of the object
  double visible = 0;         // share of the object's pixels that the silhouette kept
};

struct ViewOptions {
  bool faults = true;    // of camera and segmentation; without: the whole object, as it is
  double top_share = 0;  // of the views with faults: only what lies above some height is left
};

class ViewRenderer {
 public:
  // Errors: a mesh that rays cannot be cast at.
  [[nodiscard]] static Result<ViewRenderer> Make(FurnitureMesh furniture);
  ~ViewRenderer();
  ViewRenderer(ViewRenderer&&) noexcept;
  ViewRenderer& operator=(ViewRenderer&&) noexcept;

  // Draws until a view shows enough of the object. Thread-safe.
  [[nodiscard]] TrainingView Render(Random random, const ViewOptions& options) const;

 private:
  struct Impl;
  explicit ViewRenderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace deepslam::priors
