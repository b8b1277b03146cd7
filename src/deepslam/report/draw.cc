#include "deepslam/report/draw.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "deepslam/image_codec/jpeg.h"

namespace deepslam::report {
namespace {

constexpr int kJpegQuality = 85;  // its loss is hardly seen; more makes pages larger

// Red first, as everywhere but in OpenCV's own files.
cv::Mat ToMat(const ColourImage& picture) {
  cv::Mat rgb(picture.height(), picture.width(), CV_8UC3);
  std::memcpy(rgb.data, picture.data(), picture.size() * sizeof(Rgb8));
  return rgb;
}

cv::Scalar Colour(Rgb8 colour) { return {double(colour.r), double(colour.g), double(colour.b)}; }

void Tint(cv::Mat& rgb, const Mask& mask, Rgb8 colour) {
  if (mask.width() != rgb.cols || mask.height() != rgb.rows) return;
  const cv::Vec3b tint(colour.r, colour.g, colour.b);
  for (int v = 0; v < rgb.rows; ++v) {
    for (int u = 0; u < rgb.cols; ++u) {
      if (mask(u, v) == 0) continue;
      cv::Vec3b& p = rgb.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) p[c] = static_cast<unsigned char>((p[c] + tint[c]) / 2);
    }
  }
}

void DrawBox(cv::Mat& rgb, const Overlay& overlay) {
  if (overlay.box_px.empty()) return;
  const cv::Point a(int(std::lround(overlay.box_px.u_min)), int(std::lround(overlay.box_px.v_min)));
  const cv::Point b(int(std::lround(overlay.box_px.u_max)), int(std::lround(overlay.box_px.v_max)));
  cv::rectangle(rgb, a, b, Colour(overlay.colour), 2, cv::LINE_8);
  const cv::Point text(a.x + 3, std::max(14, a.y + 16));
  cv::putText(
      rgb, overlay.label, text, cv::FONT_HERSHEY_SIMPLEX, 0.5, cv::Scalar(0, 0, 0), 3, cv::LINE_8);
  cv::putText(rgb,
              overlay.label,
              text,
              cv::FONT_HERSHEY_SIMPLEX,
              0.5,
              cv::Scalar(255, 255, 255),
              1,
              cv::LINE_8);
}

Result<std::string> Encode(const ColourImage& picture) {
  return image_codec::EncodeJpeg(picture, kJpegQuality);
}

Result<std::string> Encode(const cv::Mat& rgb) {
  ColourImage picture(rgb.cols, rgb.rows);
  for (int v = 0; v < rgb.rows; ++v)
    std::memcpy(picture.row(v), rgb.ptr(v), static_cast<std::size_t>(rgb.cols) * sizeof(Rgb8));
  return Encode(picture);
}

}  // namespace

Result<std::string> DrawOverlays(const ColourImage& picture,
                                 std::span<const Overlay> overlays,
                                 int max_width_px) {
  if (picture.empty()) return Failed("a picture of the report is empty");
  cv::Mat rgb = ToMat(picture);
  for (const Overlay& overlay : overlays) Tint(rgb, overlay.mask, overlay.colour);
  for (const Overlay& overlay : overlays) DrawBox(rgb, overlay);
  if (rgb.cols > max_width_px) {
    const double scale = double(max_width_px) / rgb.cols;
    cv::resize(rgb, rgb, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  return Encode(rgb);
}

Result<std::string> DrawOutline(const ColourImage& crop,
                                const Mask& model,
                                Rgb8 colour,
                                int width_px) {
  if (crop.empty()) return Failed("a crop of the report is empty");
  cv::Mat rgb = ToMat(crop);
  const double scale = double(width_px) / rgb.cols;
  cv::resize(rgb, rgb, cv::Size(), scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  if (model.width() == crop.width() && model.height() == crop.height()) {
    cv::Mat mask(model.height(), model.width(), CV_8UC1);
    for (int v = 0; v < model.height(); ++v) {
      for (int u = 0; u < model.width(); ++u)
        mask.at<unsigned char>(v, u) = model(u, v) != 0 ? 255 : 0;
    }
    cv::resize(mask, mask, rgb.size(), 0, 0, cv::INTER_LINEAR);
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(mask > 127, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    cv::drawContours(rgb, contours, -1, Colour(colour), 2, cv::LINE_8);
  }
  return Encode(rgb);
}

Result<std::string> EncodeJpeg(const ColourImage& picture) {
  if (picture.empty()) return Failed("a picture of the report is empty");
  return Encode(picture);
}

}  // namespace deepslam::report
