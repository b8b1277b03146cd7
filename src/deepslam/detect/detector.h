// Finds labelled boxes in colour images. The seam for detectors; the one here is a network run by
// ONNX Runtime.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/image.h"
#include "deepslam/core/options.h"
#include "deepslam/core/result.h"
#include "deepslam/detect/letterbox.h"
#include "deepslam/geometry/box.h"

namespace deepslam::detect {

// A box as the detector names it, before the class table has a say.
struct RawDetection {
  std::string label;  // the detector's own ("dining table")
  double score = 0;   // [0, 1]
  Box2 box_px;        // clipped to the image, never empty
  Mask mask;          // instance mask of the whole image; empty where the detector makes none
};

class Detector {
 public:
  virtual ~Detector() = default;
  // Best score first; thread-safe; equal images give equal results whatever the number of threads.
  // An empty image has no detections. A grey image is a colour image with equal channels.
  [[nodiscard]] virtual Result<std::vector<RawDetection>> Detect(
      const ColourImage& image) const = 0;
  // All that it can give, in its own order.
  [[nodiscard]] virtual std::vector<std::string> labels() const = 0;
};

struct DetectorOptions {
  double min_score = 0.1;  // raw detections below are dropped
  // Non-maximum suppression: of two boxes with one label and more overlap the better stays.
  static constexpr double kMaxOverlapIou = 0.6;
  // Detections kept per image: far more than a room shows.
  static constexpr int kMaxDetections = 100;
  // Threads inside one forward pass. Not described: results do not depend on it.
  int num_threads = 1;
  // Of the images to come. The network's input is made no larger than they need (fitted_network.h);
  // others are detected as well, but smaller. Without pixels: the file's own input. Not described.
  Sides images = {};
};
void Describe(OptionsVisitor& visitor, DetectorOptions& options);

// Loads a network from the bytes of an ONNX file. The head is recognised from inputs and outputs
// (yolo_heads.h). Labels come from the metadata entry `names`; a network of 80 classes without
// names has COCO's. InvalidInput says what is wrong: not ONNX, an input that is no image, a head
// that is not known (its shapes are listed).
[[nodiscard]] Result<std::unique_ptr<Detector>> LoadNetworkDetector(std::string_view onnx_bytes,
                                                                    const DetectorOptions& options);

}  // namespace deepslam::detect
