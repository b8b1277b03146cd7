#include "deepslam/propose/shape_prior.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <onnxruntime_cxx_api.h>

#include "deepslam/propose/cut_shares.h"
#include "deepslam/shape/stretch.h"

namespace deepslam::propose {
namespace {

constexpr std::int64_t kSketchPlanes = 5;   // depth, three of normals, silhouette (docs/priors.md)
constexpr std::int64_t kSketchPixels = 64;  // a side: half of kCropSide
constexpr std::int64_t kBins = 24;  // of azimuth; bin n has its middle at n * 360 / 24 degrees
constexpr int kVersion = 2;         // 1: the decoder without its derivative
constexpr std::ptrdiff_t kFewestVoxels = 50;

using Shape = std::vector<std::int64_t>;  // without the batch

struct Port {
  const char* name;
  Shape shape;
};

std::string Text(const Shape& shape) {
  std::string text = "Nx";
  for (const std::int64_t side : shape) text += std::to_string(side) + "x";
  text.pop_back();
  return text;
}

std::string Metadata(const Ort::Session& session, const char* key) {
  Ort::AllocatorWithDefaultOptions allocator;
  const Ort::ModelMetadata metadata = session.GetModelMetadata();
  const Ort::AllocatedStringPtr text = metadata.LookupCustomMetadataMapAllocated(key, allocator);
  return text ? std::string(text.get()) : std::string();
}

std::string NameOfInput(const Ort::Session& session, std::size_t n) {
  Ort::AllocatorWithDefaultOptions allocator;
  return session.GetInputNameAllocated(n, allocator).get();
}

// Of the crop's camera: how far viewing rays run apart, elevation, whether that is known.
std::vector<float> ViewpointOf(const NetworkCrop& crop) {
  return {static_cast<float>(crop.camera.side),
          static_cast<float>(crop.elevation_rad.value_or(0)),
          crop.elevation_rad ? 1.0F : 0.0F};
}

// One of the three, with the ports it must have.
class Network {
 public:
  Network(const char* role,
          Ort::Session session,
          std::vector<Port> inputs,
          std::vector<Port> outputs)
      : role_(role),
        session_(std::move(session)),
        inputs_(std::move(inputs)),
        outputs_(std::move(outputs)) {}

  [[nodiscard]] Status Check(std::string_view class_name) const;
  [[nodiscard]] std::string MetadataOf(const std::string& key) const {
    return Metadata(session_, key.c_str());
  }
  // Inputs in the order of the ports, one item each; a single value stands for "not given". Errors:
  // what is not finite.
  [[nodiscard]] Result<std::vector<std::vector<float>>> Run(
      std::span<std::vector<float>> inputs) const;

 private:
  [[nodiscard]] Status CheckPorts(bool inputs) const;
  [[nodiscard]] Error Wrong(const std::string& what) const {
    return InvalidInput(std::string(role_) + ".onnx: " + what +
                        "; make the networks by scripts/train/train.sh");
  }

  const char* role_;
  mutable Ort::Session session_;  // Run() is thread-safe but not const
  std::vector<Port> inputs_;
  std::vector<Port> outputs_;
};

Status Network::CheckPorts(bool inputs) const {
  const std::vector<Port>& ports = inputs ? inputs_ : outputs_;
  const std::size_t count = inputs ? session_.GetInputCount() : session_.GetOutputCount();
  Ort::AllocatorWithDefaultOptions allocator;
  for (const Port& port : ports) {
    bool found = false;
    for (std::size_t n = 0; n < count && !found; ++n) {
      const std::string name = inputs ? session_.GetInputNameAllocated(n, allocator).get()
                                      : session_.GetOutputNameAllocated(n, allocator).get();
      if (name != port.name) continue;
      found = true;
      const Ort::TypeInfo type =
          inputs ? session_.GetInputTypeInfo(n) : session_.GetOutputTypeInfo(n);
      if (type.GetONNXType() != ONNX_TYPE_TENSOR ||
          type.GetTensorTypeAndShapeInfo().GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
        return Wrong("`" + name + "` is no tensor of 32-bit floats");
      const Shape shape = type.GetTensorTypeAndShapeInfo().GetShape();
      bool fits = shape.size() == port.shape.size() + 1 && shape[0] <= 1;
      for (std::size_t s = 0; fits && s < port.shape.size(); ++s)
        fits = shape[s + 1] <= 0 || shape[s + 1] == port.shape[s];
      if (!fits) return Wrong("`" + name + "` has another shape than " + Text(port.shape));
    }
    if (!found)
      return Wrong(std::string(inputs ? "no input" : "no output") + " called `" + port.name + "`");
  }
  if (inputs && count != ports.size())
    return Wrong("it has " + std::to_string(count) + " inputs, expected " +
                 std::to_string(ports.size()));
  return Ok();
}

Status Network::Check(std::string_view class_name) const {
  if (MetadataOf("format") != "deepslam/prior" || MetadataOf("role") != role_)
    return Wrong("its metadata do not say that it is the " + std::string(role_) +
                 " of a shape prior");
  const int version = std::atoi(MetadataOf("version").c_str());  // NOLINT(cert-err34-c): 0 is none
  if (version < 1 || version > kVersion)
    return Wrong("it is of version '" + MetadataOf("version") + "', this program knows up to " +
                 std::to_string(kVersion));
  if (MetadataOf("class") != class_name)
    return Wrong("it is of class '" + MetadataOf("class") + "', not '" + std::string(class_name) +
                 "'");
  if (Status status = CheckPorts(true); !status.ok()) return status;
  return CheckPorts(false);
}

Result<std::vector<std::vector<float>>> Network::Run(std::span<std::vector<float>> inputs) const {
  const Ort::MemoryInfo memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
  std::vector<Ort::Value> tensors;
  std::vector<const char*> input_names;
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    Shape shape = inputs_[n].shape;
    if (inputs[n].size() == 1) std::fill(shape.begin(), shape.end(), 1);
    shape.insert(shape.begin(), 1);
    tensors.push_back(Ort::Value::CreateTensor<float>(
        memory, inputs[n].data(), inputs[n].size(), shape.data(), shape.size()));
    input_names.push_back(inputs_[n].name);
  }
  std::vector<const char*> output_names;
  for (const Port& port : outputs_) output_names.push_back(port.name);
  const std::vector<Ort::Value> results = session_.Run(Ort::RunOptions{nullptr},
                                                       input_names.data(),
                                                       tensors.data(),
                                                       tensors.size(),
                                                       output_names.data(),
                                                       output_names.size());
  std::vector<std::vector<float>> values;
  for (std::size_t n = 0; n < results.size(); ++n) {
    std::size_t expected = 1;
    for (const std::int64_t side : outputs_[n].shape) expected *= static_cast<std::size_t>(side);
    if (results[n].GetTensorTypeAndShapeInfo().GetElementCount() != expected)
      return Wrong(std::string("`") + outputs_[n].name + "` came in another shape than " +
                   Text(outputs_[n].shape));
    const float* const data = results[n].GetTensorData<float>();
    values.emplace_back(data, data + expected);
    if (!std::all_of(
            values.back().begin(), values.back().end(), [](float v) { return std::isfinite(v); }))
      return Wrong(std::string("`") + outputs_[n].name + "` holds values that are not finite");
  }
  return values;
}

// As calibrated for crops with depth (`input` empty) or by colour alone ("_colour").
Result<SolidCut> CutOf(const Network& decoder, const std::string& input) {
  SolidCut cut;
  cut.threshold = std::strtod(decoder.MetadataOf("threshold" + input).c_str(), nullptr);
  if (!(cut.threshold > 0 && cut.threshold < 1)) {
    return InvalidInput(
        "decoder.onnx: its metadata hold no `threshold` and `threshold_colour` in (0, 1); make the "
        "networks by scripts/train/train.sh");
  }
  const std::string key = "kept_of_expected" + input;
  const std::string kept = decoder.MetadataOf(key);
  if (kept.empty()) return cut;  // of networks from before
  char* end = nullptr;
  cut.kept_of_expected = std::strtod(kept.c_str(), &end);
  if (*end != '\0' || !(cut.kept_of_expected >= 0 && cut.kept_of_expected <= 1)) {
    return InvalidInput("decoder.onnx: its metadata `" + key + "` is '" + kept +
                        "', not a number in [0, 1]; make the networks by scripts/train/train.sh");
  }
  return cut;
}

void ReadViewpoint(const std::vector<float>& azimuth, PriorEncoding& encoding) {
  const auto best = std::max_element(azimuth.begin(), azimuth.end()) - azimuth.begin();
  double sum = 0;
  for (const float logit : azimuth)
    sum += std::exp(static_cast<double>(logit - azimuth[static_cast<std::size_t>(best)]));
  double c = 0;
  double s = 0;
  for (std::ptrdiff_t step = -1; step <= 1; ++step) {
    const auto bin = static_cast<std::size_t>((best + step + kBins) % kBins);
    const double share =
        std::exp(static_cast<double>(azimuth[bin] - azimuth[static_cast<std::size_t>(best)])) / sum;
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(bin) / kBins;
    c += share * std::cos(angle);
    s += share * std::sin(angle);
    encoding.confidence += share;
  }
  encoding.azimuth_rad = std::atan2(s, c);
}

VoxelGrid Canonical(const VoxelGrid& solid) {
  return shape::StretchGrid(solid, Eigen::Vector3d::Ones());
}

Eigen::Vector3d CenterOf(const VoxelBox& box) {
  return 0.5 * (VoxelGrid::Center(box.low.x(), box.low.y(), box.low.z()) +
                VoxelGrid::Center(box.high.x(), box.high.y(), box.high.z()));
}

}  // namespace

struct ShapePrior::Impl {
  Ort::Env env;
  Network sketch;
  Network encoder;
  Network decoder;
  std::size_t num_viewpoint_values = 0;  // the first of ViewpointOf() that the encoder asks for
  bool has_gradient = false;
  SolidCut cut_by_depth;
  SolidCut cut_by_colour;

  // Of the decoder: logits, and the derivative by the latents where there is one.
  [[nodiscard]] Result<std::vector<std::vector<float>>> RunDecoder(
      std::span<const float> latents, std::span<const float> gradient_by_logits) const;
  // The solid on the decoder's own grid.
  [[nodiscard]] Result<VoxelGrid> SolidOf(std::span<const float> logits, bool by_depth) const;
};

Result<std::vector<std::vector<float>>> ShapePrior::Impl::RunDecoder(
    std::span<const float> latents, std::span<const float> gradient_by_logits) const try {
  if (latents.size() != kNumLatents ||
      !std::all_of(latents.begin(), latents.end(), [](float v) { return std::isfinite(v); }))
    return InvalidInput("latents must be " + std::to_string(kNumLatents) + " finite numbers");
  std::vector<std::vector<float>> inputs(1, {latents.begin(), latents.end()});
  if (has_gradient && gradient_by_logits.empty()) inputs.push_back({0.0F});
  if (has_gradient && !gradient_by_logits.empty())
    inputs.emplace_back(gradient_by_logits.begin(), gradient_by_logits.end());
  return decoder.Run(inputs);
} catch (const std::exception& failure) {
  return Failed(std::string("the shape decoder failed: ") + failure.what());
}

Result<VoxelGrid> ShapePrior::Impl::SolidOf(std::span<const float> logits, bool by_depth) const {
  if (logits.size() != VoxelGrid().occupied.size())
    return InvalidInput("logits must have a number for each voxel");
  std::vector<float> shares(logits.size());
  std::transform(logits.begin(), logits.end(), shares.begin(), [](float logit) {
    return 1.0F / (1.0F + std::exp(-logit));
  });
  VoxelGrid solid = CutShares(shares, by_depth ? cut_by_depth : cut_by_colour);
  if (std::count(solid.occupied.begin(), solid.occupied.end(), std::uint8_t{1}) < kFewestVoxels)
    return InvalidInput("the latents decode to no solid");
  return solid;
}

ShapePrior::ShapePrior(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ShapePrior::~ShapePrior() = default;

namespace {

// Sessions of one class's networks, each on one thread: proposals are made side by side.
class SessionOpener {
 public:
  // `role` becomes that of the network being opened, for messages about what is thrown.
  explicit SessionOpener(const char*& role)
      : role_(&role), env_(ORT_LOGGING_LEVEL_FATAL, "deepslam") {
    options_.SetIntraOpNumThreads(1);
    options_.SetInterOpNumThreads(1);
  }

  Ort::Session Open(const char* role, std::string_view bytes) {
    *role_ = role;
    return Ort::Session(env_, bytes.data(), bytes.size(), options_);
  }
  [[nodiscard]] Ort::Env TakeEnv() { return std::move(env_); }

 private:
  const char** role_;
  Ort::Env env_;
  Ort::SessionOptions options_;
};

const Port& CropPort() {
  static const Port port = {"crop", {kCropPlanes, kCropSide, kCropSide}};
  return port;
}
const Port& SketchPort() {
  static const Port port = {"sketch", {kSketchPlanes, kSketchPixels, kSketchPixels}};
  return port;
}
const Port& LatentsPort() {
  static const Port port = {"latents", {static_cast<std::int64_t>(kNumLatents)}};
  return port;
}

// `num_viewpoint_values` becomes how many numbers it takes of how an object was seen.
Network MakeEncoder(Ort::Session session, std::size_t& num_viewpoint_values) {
  std::vector<Port> inputs = {CropPort(), SketchPort()};
  num_viewpoint_values = 0;
  if (session.GetInputCount() > 2) {
    num_viewpoint_values = NameOfInput(session, 2) == "sight" ? 3 : 1;
    inputs.push_back({num_viewpoint_values == 3 ? "sight" : "spread",
                      {static_cast<std::int64_t>(num_viewpoint_values)}});
  }
  return {"encoder",
          std::move(session),
          std::move(inputs),
          {LatentsPort(), {"azimuth", {kBins}}, {"elevation", {1}}}};
}

// `has_gradient` becomes whether it gives the gradient of its latents as well.
Network MakeDecoder(Ort::Session session, bool& has_gradient) {
  const Port cotangent = {"cotangent", {kGridSize, kGridSize, kGridSize}};
  has_gradient = Metadata(session, "version") != "1";
  std::vector<Port> inputs = {LatentsPort()};
  std::vector<Port> outputs = {{"logits", cotangent.shape}};
  if (has_gradient) {
    inputs.push_back(cotangent);
    outputs.push_back({"latent_gradient", LatentsPort().shape});
  }
  return {"decoder", std::move(session), std::move(inputs), std::move(outputs)};
}

}  // namespace

Result<std::unique_ptr<ShapePrior>> ShapePrior::Load(std::string_view class_name,
                                                     std::string_view sketch_onnx,
                                                     std::string_view encoder_onnx,
                                                     std::string_view decoder_onnx) {
  const char* opening = "sketch";
  try {
    SessionOpener opener(opening);
    std::size_t num_viewpoint_values = 0;
    bool has_gradient = false;
    Network sketch("sketch", opener.Open("sketch", sketch_onnx), {CropPort()}, {SketchPort()});
    Network encoder = MakeEncoder(opener.Open("encoder", encoder_onnx), num_viewpoint_values);
    Network decoder = MakeDecoder(opener.Open("decoder", decoder_onnx), has_gradient);
    for (const Network* network : {&sketch, &encoder, &decoder}) {
      if (Status status = network->Check(class_name); !status.ok()) return status.error();
    }
    const Result<SolidCut> by_depth = CutOf(decoder, "");
    if (!by_depth) return by_depth.error();
    const Result<SolidCut> by_colour = CutOf(decoder, "_colour");
    if (!by_colour) return by_colour.error();
    auto impl = std::unique_ptr<Impl>(new Impl{opener.TakeEnv(),
                                               std::move(sketch),
                                               std::move(encoder),
                                               std::move(decoder),
                                               num_viewpoint_values,
                                               has_gradient,
                                               *by_depth,
                                               *by_colour});
    return std::unique_ptr<ShapePrior>(new ShapePrior(std::move(impl)));
  } catch (const std::exception& failure) {
    return InvalidInput(std::string(opening) +
                        ".onnx: not a network that can be run: " + failure.what());
  }
}

Result<PriorEncoding> ShapePrior::Encode(const NetworkCrop& crop) const try {
  std::vector<std::vector<float>> inputs(1, std::vector<float>(kCropValues));
  FillPlanes(crop, inputs[0]);
  Result<std::vector<std::vector<float>>> sketch = impl_->sketch.Run(inputs);
  if (!sketch.ok()) return sketch.error();
  inputs.push_back(std::move((*sketch)[0]));
  if (impl_->num_viewpoint_values > 0) {
    inputs.push_back(ViewpointOf(crop));
    inputs.back().resize(impl_->num_viewpoint_values);
  }
  const Result<std::vector<std::vector<float>>> outputs = impl_->encoder.Run(inputs);
  if (!outputs.ok()) return outputs.error();
  PriorEncoding encoding;
  std::copy((*outputs)[0].begin(), (*outputs)[0].end(), encoding.latents.begin());
  ReadViewpoint((*outputs)[1], encoding);
  encoding.elevation_rad = (*outputs)[2][0];
  return encoding;
} catch (const std::exception& failure) {
  return Failed(std::string("the shape network failed: ") + failure.what());
}

Result<VoxelGrid> ShapePrior::Decode(std::span<const float> latents, bool by_depth) const {
  const Result<std::vector<float>> logits = Logits(latents);
  if (!logits.ok()) return logits.error();
  return Solid(*logits, by_depth);
}

Result<VoxelGrid> ShapePrior::Solid(std::span<const float> logits, bool by_depth) const {
  const Result<VoxelGrid> solid = impl_->SolidOf(logits, by_depth);
  if (!solid.ok()) return solid.error();
  return Canonical(*solid);
}

Result<Similarity3> ShapePrior::ObjectFromDecoded(std::span<const float> latents,
                                                  bool by_depth) const {
  const Result<std::vector<float>> logits = Logits(latents);
  if (!logits.ok()) return logits.error();
  const Result<VoxelGrid> decoded = impl_->SolidOf(*logits, by_depth);
  if (!decoded.ok()) return decoded.error();
  const std::optional<VoxelBox> from = OccupiedBox(*decoded);
  const std::optional<VoxelBox> to = OccupiedBox(Canonical(*decoded));
  if (!from || !to) return InvalidInput("the latents decode to no solid");
  Similarity3 object_from_decoded;
  object_from_decoded.scale =
      static_cast<double>(to->sides().maxCoeff()) / from->sides().maxCoeff();
  object_from_decoded.translation_m = CenterOf(*to) - object_from_decoded.scale * CenterOf(*from);
  return object_from_decoded;
}

Result<std::vector<float>> ShapePrior::Logits(std::span<const float> latents) const {
  Result<std::vector<std::vector<float>>> outputs = impl_->RunDecoder(latents, {});
  if (!outputs.ok()) return outputs.error();
  return std::move((*outputs)[0]);
}

bool ShapePrior::HasGradient() const { return impl_->has_gradient; }

Result<std::vector<float>> ShapePrior::LatentGradient(
    std::span<const float> latents, std::span<const float> gradient_by_logits) const {
  if (!HasGradient())
    return InvalidInput(
        "decoder.onnx came without its derivative; scripts/train/decoder_gradient.py adds it");
  if (gradient_by_logits.size() != VoxelGrid().occupied.size())
    return InvalidInput("a derivative by the logits must have a number for each voxel");
  Result<std::vector<std::vector<float>>> outputs = impl_->RunDecoder(latents, gradient_by_logits);
  if (!outputs.ok()) return outputs.error();
  return std::move((*outputs)[1]);
}

}  // namespace deepslam::propose
