// The ONNX files of a shape prior, all three of the same bytes: what is checked are ports and
// metadata. ONNX Runtime itself is not instrumented.
#include "deepslam/propose/shape_prior.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(shape_prior) {
  const auto prior = propose::ShapePrior::Load("chair", bytes, bytes, bytes);
  return prior.ok() || prior.error().message.find(".onnx: not a network") == std::string::npos;
}
