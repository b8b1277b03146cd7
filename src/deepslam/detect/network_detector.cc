#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include <onnxruntime_cxx_api.h>
#include <opencv2/imgproc.hpp>

#include "deepslam/detect/detector.h"
#include "deepslam/detect/fitted_network.h"
#include "deepslam/detect/letterbox.h"
#include "deepslam/detect/yolo_heads.h"

namespace deepslam::detect {
namespace {

// Input side where the network leaves it open; what the family is trained at.
constexpr int kDynamicSide = 640;
constexpr float kPadValue = 114.0F;  // grey the family is trained with

std::vector<std::int64_t> FirstInputShape(const Ort::Session& session) {
  return session.GetInputTypeInfo(0).GetTensorTypeAndShapeInfo().GetShape();
}

std::string Metadata(const Ort::Session& session, const char* key) {
  Ort::AllocatorWithDefaultOptions allocator;
  const Ort::ModelMetadata metadata = session.GetModelMetadata();
  const Ort::AllocatedStringPtr text = metadata.LookupCustomMetadataMapAllocated(key, allocator);
  return text ? std::string(text.get()) : std::string();
}

// Planar input tensor. YOLOX takes BGR in [0, 255], the others RGB in [0, 1].
std::vector<float> PlanarInput(const ColourImage& image,
                               const Letterbox& letterbox,
                               const HeadLayout& layout) {
  const bool yolox = layout.kind == HeadKind::kYoloX;
  const float gain = yolox ? 1.0F : 1.0F / 255.0F;
  static_assert(sizeof(Rgb8) == 3);
  const cv::Mat source(image.height(),
                       image.width(),
                       CV_8UC3,
                       const_cast<Rgb8*>(image.data()));  // NOLINT: cv::Mat has no const view
  cv::Mat scaled = source;
  if (letterbox.width_px != image.width() || letterbox.height_px != image.height()) {
    cv::resize(source, scaled, {letterbox.width_px, letterbox.height_px}, 0, 0, cv::INTER_LINEAR);
  }
  const auto width = static_cast<std::size_t>(layout.input_width);
  const std::size_t plane = width * static_cast<std::size_t>(layout.input_height);
  std::vector<float> input(3 * plane, kPadValue * gain);
  for (int v = 0; v < letterbox.height_px; ++v) {
    const auto* row = scaled.ptr<cv::Vec3b>(v);
    const std::size_t start = static_cast<std::size_t>(v + letterbox.pad_v_px) * width +
                              static_cast<std::size_t>(letterbox.pad_u_px);
    for (int u = 0; u < letterbox.width_px; ++u) {
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(yolox ? 2 - c : c);
        input[channel * plane + start + static_cast<std::size_t>(u)] =
            gain * static_cast<float>(row[u][c]);
      }
    }
  }
  return input;
}

using OutputShapes = std::vector<std::vector<std::int64_t>>;

Error NoFloatTensors() {
  return InvalidInput("the network's outputs are no float tensors: not a known detector");
}

class NetworkDetector final : public Detector {
 public:
  NetworkDetector(Ort::Env env, Ort::Session session, const DetectorOptions& options)
      : env_(std::move(env)), session_(std::move(session)), options_(options) {}

  // Reads names and head; an Error when this is no detector that is known here.
  Status Prepare();
  [[nodiscard]] Result<std::vector<RawDetection>> Detect(const ColourImage& image) const override;
  [[nodiscard]] std::vector<std::string> labels() const override { return labels_; }

 private:
  [[nodiscard]] Status PrepareInput();
  [[nodiscard]] Result<OutputShapes> StatedOutputShapes() const;
  [[nodiscard]] Result<OutputShapes> ShapesOfAPass() const;
  [[nodiscard]] bool HasOutputShapes(const std::vector<Ort::Value>& outputs) const;
  [[nodiscard]] std::vector<Ort::Value> Run(std::vector<float>& input) const;

  Ort::Env env_;
  mutable Ort::Session session_;  // Run() is thread-safe but not const
  DetectorOptions options_;
  HeadLayout layout_;
  OutputShapes output_shapes_;
  std::vector<std::string> labels_;
  std::string input_name_;
  std::vector<std::string> output_names_;
};

Status NetworkDetector::PrepareInput() {
  if (session_.GetInputCount() != 1) {
    return InvalidInput("the network has " + std::to_string(session_.GetInputCount()) +
                        " inputs; a detector has one, an image of 1x3xHxW");
  }
  const Ort::TypeInfo type = session_.GetInputTypeInfo(0);
  if (type.GetONNXType() != ONNX_TYPE_TENSOR ||
      type.GetTensorTypeAndShapeInfo().GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT) {
    return InvalidInput("the network's input is no float tensor; export it with 32-bit floats");
  }
  const std::vector<std::int64_t> shape = FirstInputShape(session_);
  const auto side = [](std::int64_t value) { return value <= 0 ? kDynamicSide : value; };
  if (shape.size() != 4 || shape[0] > 1 || (shape[1] != 3 && shape[1] > 0) ||
      !CanBeInput(side(shape[3]), side(shape[2]))) {
    std::string text;
    for (const std::int64_t s : shape) {
      if (!text.empty()) text += 'x';
      text += std::to_string(s);
    }
    return InvalidInput(
        "the network's input is " + text + "; expected 1x3xHxW with sides that are multiples of " +
        std::to_string(kCoarsestStride_px) + " up to " + std::to_string(kLargestSide));
  }
  const Sides largest = {static_cast<int>(side(shape[3])), static_cast<int>(side(shape[2]))};
  const Sides fitted = FitSides(options_.images, largest);
  layout_.input_height = shape[2] > 0 ? largest.height : fitted.height;
  layout_.input_width = shape[3] > 0 ? largest.width : fitted.width;
  Ort::AllocatorWithDefaultOptions allocator;
  input_name_ = session_.GetInputNameAllocated(0, allocator).get();
  for (std::size_t i = 0; i < session_.GetOutputCount(); ++i) {
    output_names_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
  }
  return Ok();
}

// Nothing where the network leaves one of them open.
Result<OutputShapes> NetworkDetector::StatedOutputShapes() const {
  OutputShapes shapes;
  for (std::size_t i = 0; i < session_.GetOutputCount(); ++i) {
    const Ort::TypeInfo type = session_.GetOutputTypeInfo(i);
    if (type.GetONNXType() != ONNX_TYPE_TENSOR) return NoFloatTensors();
    const auto tensor = type.GetTensorTypeAndShapeInfo();
    if (tensor.GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT) return NoFloatTensors();
    shapes.push_back(tensor.GetShape());
    if (std::ranges::any_of(shapes.back(), [](std::int64_t side) { return side <= 0; }))
      return OutputShapes();
  }
  return shapes;
}

// What a forward pass of a grey image gives.
Result<OutputShapes> NetworkDetector::ShapesOfAPass() const {
  std::vector<float> input(3 * static_cast<std::size_t>(layout_.input_width) *
                               static_cast<std::size_t>(layout_.input_height),
                           0.5F);
  OutputShapes shapes;
  for (const Ort::Value& output : Run(input)) {
    if (!output.IsTensor() || output.GetTensorTypeAndShapeInfo().GetElementType() !=
                                  ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT) {
      return NoFloatTensors();
    }
    shapes.push_back(output.GetTensorTypeAndShapeInfo().GetShape());
  }
  return shapes;
}

Status NetworkDetector::Prepare() {
  if (const Status status = PrepareInput(); !status.ok()) return status;
  labels_ = ParseNames(Metadata(session_, "names"));
  Result<OutputShapes> shapes = StatedOutputShapes();
  if (shapes.ok() && shapes->empty()) shapes = ShapesOfAPass();
  if (!shapes.ok()) return shapes.error();
  Result<HeadLayout> layout = RecogniseHead(
      *shapes, static_cast<int>(labels_.size()), layout_.input_width, layout_.input_height);
  if (!layout.ok()) return layout.error();
  layout_ = *layout;
  output_shapes_ = *std::move(shapes);
  if (labels_.empty() && layout_.num_classes == static_cast<int>(CocoLabels().size())) {
    labels_ = CocoLabels();
  }
  if (labels_.empty()) {
    return InvalidInput("the network has " + std::to_string(layout_.num_classes) +
                        " classes but no metadata entry `names` that says what they are");
  }
  return Ok();
}

std::vector<Ort::Value> NetworkDetector::Run(std::vector<float>& input) const {
  const std::array<std::int64_t, 4> shape = {1, 3, layout_.input_height, layout_.input_width};
  const Ort::MemoryInfo memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
  Ort::Value tensor = Ort::Value::CreateTensor<float>(
      memory, input.data(), input.size(), shape.data(), shape.size());
  std::vector<const char*> outputs;
  for (const std::string& name : output_names_) outputs.push_back(name.c_str());
  const char* input_name = input_name_.c_str();
  return session_.Run(
      Ort::RunOptions{nullptr}, &input_name, &tensor, 1, outputs.data(), outputs.size());
}

// What a file states of its outputs need not be true.
bool NetworkDetector::HasOutputShapes(const std::vector<Ort::Value>& outputs) const {
  return std::ranges::equal(outputs,
                            output_shapes_,
                            [](const Ort::Value& output, const std::vector<std::int64_t>& shape) {
                              if (!output.IsTensor()) return false;
                              const auto tensor = output.GetTensorTypeAndShapeInfo();
                              return tensor.GetElementType() ==
                                         ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT &&
                                     tensor.GetShape() == shape;
                            });
}

Result<std::vector<RawDetection>> NetworkDetector::Detect(const ColourImage& image) const try {
  if (image.empty()) return std::vector<RawDetection>();
  const Padding padding = layout_.kind == HeadKind::kYoloX ? Padding::kTopLeft : Padding::kCentred;
  const Letterbox letterbox = FitLetterbox(
      image.width(), image.height(), layout_.input_width, layout_.input_height, padding);
  std::vector<float> input = PlanarInput(image, letterbox, layout_);
  const std::vector<Ort::Value> outputs = Run(input);
  if (!HasOutputShapes(outputs))
    return InvalidInput("the network's outputs have other shapes than its file states");
  const auto values = [](const Ort::Value& output) {
    return std::span<const float>(output.GetTensorData<float>(),
                                  output.GetTensorTypeAndShapeInfo().GetElementCount());
  };
  const std::vector<HeadBox> boxes =
      SuppressOverlaps(DecodeHead(values(outputs[0]), layout_, options_.min_score),
                       DetectorOptions::kMaxOverlapIou,
                       DetectorOptions::kMaxDetections);
  std::vector<RawDetection> detections;
  for (const HeadBox& box : boxes) {
    RawDetection detection;
    detection.label = labels_[static_cast<std::size_t>(box.label_idx)];
    detection.score = box.score;
    detection.box_px = ToImage(letterbox, box.box_input, image.width(), image.height());
    if (detection.box_px.empty()) continue;
    if (layout_.kind == HeadKind::kYoloV8Seg) {
      detection.mask = DecodeInstanceMask(box.coefficients,
                                          values(outputs[1]),
                                          layout_,
                                          letterbox,
                                          detection.box_px,
                                          image.width(),
                                          image.height());
    }
    detections.push_back(std::move(detection));
  }
  return detections;
} catch (const std::exception& failure) {
  return Failed(std::string("the detector's network failed on an image of ") +
                std::to_string(image.width()) + "x" + std::to_string(image.height()) + ": " +
                failure.what());
}

// Of a file as it is.
Result<std::unique_ptr<Detector>> Load(std::string_view onnx_bytes,
                                       const DetectorOptions& options) try {
  Ort::Env env(ORT_LOGGING_LEVEL_FATAL, "deepslam");
  Ort::SessionOptions session_options;
  session_options.SetIntraOpNumThreads(std::max(1, options.num_threads));
  session_options.SetInterOpNumThreads(1);
  // Waiting threads must not take the cores from other work.
  session_options.AddConfigEntry("session.intra_op.allow_spinning", "0");
  Ort::Session session(env, onnx_bytes.data(), onnx_bytes.size(), session_options);
  auto detector = std::make_unique<NetworkDetector>(std::move(env), std::move(session), options);
  if (const Status status = detector->Prepare(); !status.ok()) return status.error();
  return std::unique_ptr<Detector>(std::move(detector));
} catch (const std::exception& failure) {
  return InvalidInput("not a network that can be run (" + std::to_string(onnx_bytes.size()) +
                      " bytes, an ONNX file is expected): " + failure.what());
}

}  // namespace

void Describe(OptionsVisitor& visitor, DetectorOptions& options) {
  visitor.Field("min_score",
                options.min_score,
                {0.001, 1},
                "1",
                "raw detections with a lower score are dropped");
}

Result<std::unique_ptr<Detector>> LoadNetworkDetector(std::string_view onnx_bytes,
                                                      const DetectorOptions& options) {
  if (onnx_bytes.empty()) return InvalidInput("the network's file is empty");
  if (const auto fitted = FittedNetwork(onnx_bytes, options.images)) {
    Result<std::unique_ptr<Detector>> detector = Load(*fitted, options);
    if (detector.ok()) return detector;
  }
  return Load(onnx_bytes, options);
}

}  // namespace deepslam::detect
