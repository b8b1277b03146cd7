// What a stage of the pipeline is: a named, versioned function from the files of other stages to
// files of its own.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/progress.h"
#include "deepslam/core/result.h"
#include "deepslam/core/text_pieces.h"
#include "deepslam/storage/scratch_file.h"

namespace deepslam::pipeline {

// One line for people and a few figures for programs. Neither may depend on clocks, threads or
// paths: both stand in the manifest, which is byte-equal between equal runs.
struct StageSummary {
  std::string line;
  std::map<std::string, double> figures;
};

struct OutputFile {
  std::string sha256;
  std::uintmax_t num_bytes = 0;
  friend bool operator==(const OutputFile&, const OutputFile&) = default;
};

// A running stage's way to its files.
class StageContext {
 public:
  StageContext(std::filesystem::path workspace,
               std::filesystem::path folder,
               std::vector<std::string> inputs,
               Progress& progress);

  // Bytes of a file another stage wrote; the stage must be among the declared inputs. `file` is
  // relative to its folder.
  [[nodiscard]] Result<std::string> Read(std::string_view stage, std::string_view file) const;
  // The same by pieces, for texts that grow with the capture.
  [[nodiscard]] Result<TextSource> Open(std::string_view stage, std::string_view file) const;
  // Writes a file of this stage's output, `file` relative ("models/a.binvox").
  [[nodiscard]] Status Write(std::string_view file, std::string_view bytes);
  [[nodiscard]] Status Write(std::string_view file, const TextWriter& text);
  // A file for the time of the stage, beside what it writes. A stage that could not read it back is
  // failed when it is done. Thread-safe.
  [[nodiscard]] std::shared_ptr<storage::ScratchFile> Scratch() const;
  // The stages whose files may be read, in the order declared.
  [[nodiscard]] const std::vector<std::string>& inputs() const { return inputs_; }
  [[nodiscard]] Progress& progress() const { return progress_; }
  // How messages call a file: "track/frames.json".
  [[nodiscard]] static std::string DisplayName(std::string_view stage, std::string_view file);
  [[nodiscard]] const std::map<std::string, OutputFile>& outputs() const { return outputs_; }
  // What the machine did not give back of the scratch files.
  [[nodiscard]] std::optional<Error> scratch_fault() const;

 private:
  [[nodiscard]] std::filesystem::path PathTo(std::string_view stage, std::string_view file) const;

  std::filesystem::path workspace_;
  std::filesystem::path folder_;
  std::vector<std::string> inputs_;
  Progress& progress_;
  std::map<std::string, OutputFile> outputs_;
  mutable std::mutex scratch_mutex_;
  mutable std::vector<std::shared_ptr<storage::ScratchFile>> scratch_;
};

struct Stage {
  std::string name;
  int version = 1;                  // raised whenever results may differ with equal options
  std::vector<std::string> inputs;  // stages whose files are read
  std::map<std::string, std::string>
      options;  // full name -> canonical value; no paths, no thread counts
  // Content hashes of inputs that are no stages: the capture, weights, a library, a user's file.
  // Asked once per run, before anything runs, so that a missing file is told at once.
  std::function<Result<std::map<std::string, std::string>>()> external_inputs;
  std::function<Result<StageSummary>(StageContext&)> run;
};

}  // namespace deepslam::pipeline
