#include "deepslam/report/draw.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace deepslam::report {
namespace {

constexpr int kJpegQuality = 85;

cv::Mat ToBgr(const ColourImage& picture) {
  cv::Mat bgr(picture.height(), picture.width(), CV_8UC3);
  for (int v = 0; v < picture.height(); ++v) {
    for (int u = 0; u < picture.width(); ++u) {
      const Rgb8& p = picture(u, v);
      bgr.at<cv::Vec3b>(v, u) = cv::Vec3b(p.b, p.g, p.r);
    }
  }
  return bgr;
}

cv::Scalar Bgr(Rgb8 colour) { return {double(colour.b), double(colour.g), double(colour.r)}; }

void Tint(cv::Mat& bgr, const Mask& mask, Rgb8 colour) {
  if (mask.width() != bgr.cols || mask.height() != bgr.rows) return;
  const cv::Vec3b tint(colour.b, colour.g, colour.r);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      if (mask(u, v) == 0) continue;
      cv::Vec3b& p = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) p[c] = static_cast<unsigned char>((p[c] + tint[c]) / 2);
    }
  }
}

void DrawBox(cv::Mat& bgr, const Overlay& overlay) {
  if (overlay.box_px.empty()) return;
  const cv::Point a(int(std::lround(overlay.box_px.u_min)), int(std::lround(overlay.box_px.v_min)));
  const cv::Point b(int(std::lround(overlay.box_px.u_max)), int(std::lround(overlay.box_px.v_max)));
  cv::rectangle(bgr, a, b, Bgr(overlay.colour), 2, cv::LINE_8);
  const cv::Point text(a.x + 3, std::max(14, a.y + 16));
  cv::putText(
      bgr, overlay.label, text, cv::FONT_HERSHEY_SIMPLEX, 0.5, cv::Scalar(0, 0, 0), 3, cv::LINE_8);
  cv::putText(bgr,
              overlay.label,
              text,
              cv::FONT_HERSHEY_SIMPLEX,
              0.5,
              cv::Scalar(255, 255, 255),
              1,
              cv::LINE_8);
}

Result<std::string> Encode(const cv::Mat& bgr) {
  try {
    std::vector<unsigned char> bytes;
    if (!cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality})) {
      return Failed("a picture of the report could not be encoded");
    }
    return std::string(bytes.begin(), bytes.end());
  } catch (const cv::Exception& e) {
    return Failed(std::string("a picture of the report could not be encoded: ") + e.what());
  }
}

}  // namespace

Result<std::string> DrawOverlays(const ColourImage& picture,
                                 std::span<const Overlay> overlays,
                                 int max_width_px) {
  if (picture.empty()) return Failed("a picture of the report is empty");
  cv::Mat bgr = ToBgr(picture);
  for (const Overlay& overlay : overlays) Tint(bgr, overlay.mask, overlay.colour);
  for (const Overlay& overlay : overlays) DrawBox(bgr, overlay);
  if (bgr.cols > max_width_px) {
    const double scale = double(max_width_px) / bgr.cols;
    cv::resize(bgr, bgr, cv::Size(), scale, scale, cv::INTER_AREA);
  }
  return Encode(bgr);
}

Result<std::string> DrawOutline(const ColourImage& crop,
                                const Mask& model,
                                Rgb8 colour,
                                int width_px) {
  if (crop.empty()) return Failed("a crop of the report is empty");
  cv::Mat bgr = ToBgr(crop);
  const double scale = double(width_px) / bgr.cols;
  cv::resize(bgr, bgr, cv::Size(), scale, scale, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  if (model.width() == crop.width() && model.height() == crop.height()) {
    cv::Mat mask(model.height(), model.width(), CV_8UC1);
    for (int v = 0; v < model.height(); ++v) {
      for (int u = 0; u < model.width(); ++u)
        mask.at<unsigned char>(v, u) = model(u, v) != 0 ? 255 : 0;
    }
    cv::resize(mask, mask, bgr.size(), 0, 0, cv::INTER_LINEAR);
    std::vector<std::vector<cv::Point>> contours;
    cv::findContours(mask > 127, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
    cv::drawContours(bgr, contours, -1, Bgr(colour), 2, cv::LINE_8);
  }
  return Encode(bgr);
}

Result<std::string> EncodeJpeg(const ColourImage& picture) {
  if (picture.empty()) return Failed("a picture of the report is empty");
  return Encode(ToBgr(picture));
}

}  // namespace deepslam::report
