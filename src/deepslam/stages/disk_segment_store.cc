#include "deepslam/stages/disk_segment_store.h"

#include <string>
#include <utility>

#include "deepslam/artifact/segments_json.h"

namespace deepslam::stages {

using pipeline::StageContext;

Result<std::shared_ptr<const DiskSegmentStore>> DiskSegmentStore::Read(
    const StageContext& context) {
  Result<TextSource> text = context.Open("associate", "segments.json");
  if (!text.ok()) return text.error();
  const auto store = std::make_shared<DiskSegmentStore>();
  store->file_ = context.Scratch();
  const Status read =
      artifact::DecodeEachSegment(std::move(text).value(),
                                  StageContext::DisplayName("associate", "segments.json"),
                                  [&](Segment segment) { return store->Add(std::move(segment)); });
  if (!read.ok()) return read.error();
  return std::shared_ptr<const DiskSegmentStore>(store);
}

Status DiskSegmentStore::Add(Segment segment) {
  const PixelMask mask = std::exchange(segment.mask, {});
  masks_.push_back({file_->num_bytes(), mask.rle().size(), mask.width(), mask.height()});
  segments_.push_back(std::move(segment));
  return mask.empty() ? Ok() : file_->Append(std::as_bytes(std::span(mask.rle())));
}

Result<PixelMask> DiskSegmentStore::MaskAt(const Place& place) const {
  if (place.width == 0 || place.height == 0) return PixelMask();
  std::string rle(place.num_bytes, '\0');
  file_->Read(place.at, std::as_writable_bytes(std::span(rle)));
  if (const auto fault = file_->fault()) return *fault;
  return PixelMask::FromRle(rle, place.width, place.height);
}

Result<std::vector<Segment>> DiskSegmentStore::Of(const std::set<DetectionId>& wanted) const {
  std::vector<Segment> found;
  for (std::size_t n = 0; n < segments_.size(); ++n) {
    if (!wanted.contains(segments_[n].detection)) continue;
    Result<PixelMask> mask = MaskAt(masks_[n]);
    if (!mask.ok()) return mask.error();
    found.push_back(segments_[n]);
    found.back().mask = std::move(mask).value();
  }
  return found;
}

}  // namespace deepslam::stages
