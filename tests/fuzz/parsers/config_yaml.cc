// Configuration overlays and what stands behind --set.
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/pipeline/config.h"
#include "fuzz/entry.h"

namespace deepslam::fuzz {
namespace {

struct Options {
  double real = 0.5;
  int whole = 3;
  bool flag = true;
  std::string text = "yolov8s";
  std::string choice = "one";
  double deeper = 1;
};

std::vector<pipeline::OptionSection> Sections(Options& o) {
  static constexpr std::array<std::string_view, 2> kChoices = {"one", "two"};
  return {{"track",
           "the first section",
           [&o](OptionsVisitor& visitor) {
             visitor.Field("real", o.real, {0, 10}, "m", "a real number");
             visitor.Field("whole", o.whole, {-5, 100}, "1", "a whole number");
             visitor.Field("flag", o.flag, "a flag");
             visitor.Field("text", o.text, "a text");
             visitor.Choice("choice", o.choice, kChoices, "one of two");
           }},
          {"track.inner", "a section below", [&o](OptionsVisitor& visitor) {
             visitor.Field("deeper", o.deeper, {-1e9, 1e9}, "s", "another number");
           }}};
}

}  // namespace
}  // namespace deepslam::fuzz

DEEPSLAM_FUZZ(config_yaml) {
  Options set;
  const std::vector<std::string> settings = {std::string(bytes)};
  (void)pipeline::ApplySettings(Sections(set), settings);

  Options options;
  const auto sections = Sections(options);
  if (const Status status = pipeline::ApplyYaml(sections, bytes, kFile); !status.ok())
    return Refused(status.error());
  Options copy;
  const auto copied = Sections(copy);
  const std::string text = pipeline::DumpConfig(sections);
  const Status again = pipeline::ApplyYaml(copied, text, "dump");
  DEEPSLAM_CHECK(again.ok(), "a dump can be read");
  DEEPSLAM_CHECK(pipeline::DumpConfig(copied) == text, "reading a dump changes nothing");
  return true;
}
