// The subcommands of `deepslam`. Each adds itself to the command line and sets `chosen` when it was
// asked for; the function it sets does the work and returns the exit code.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/stages/config.h"

namespace CLI {
class App;
}

namespace deepslam::tools {

using Command = std::function<int()>;

void AddRun(CLI::App& app, Command& chosen);
void AddBatch(CLI::App& app, Command& chosen);
void AddBatchSummary(CLI::App& app, Command& chosen);
void AddBatchWorker(CLI::App& app, Command& chosen);
void AddStatus(CLI::App& app, Command& chosen);
void AddConfig(CLI::App& app, Command& chosen);
void AddDoctor(CLI::App& app, Command& chosen);
void AddValidate(CLI::App& app, Command& chosen);
void AddExpand(CLI::App& app, Command& chosen);
void AddConvert(CLI::App& app, Command& chosen);
void AddEval(CLI::App& app, Command& chosen);
void AddSynth(CLI::App& app, Command& chosen);
void AddLibrary(CLI::App& app, Command& chosen);
void AddForms(CLI::App& app, Command& chosen);
void AddPriors(CLI::App& app, Command& chosen);
void AddVersion(CLI::App& app, Command& chosen);

// 0 done, 1 failed, 2 wrong usage or configuration, 3 input unusable, 130 interrupted.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;         // what was asked for could not be done
inline constexpr int kExitUsage = 2;          // command line or configuration
inline constexpr int kExitInput = 3;          // files that were given
inline constexpr int kExitInterrupted = 130;  // 128 + SIGINT, as shells give it

[[nodiscard]] int ExitCodeOf(ErrorCode code);
// Prints the message and gives the exit code that goes with it.
[[nodiscard]] int ReportError(const Error& error);

// Where options come from, in order: `files` (YAML), `settings` (name=value). All faults at once.
struct ConfigSources {
  std::vector<std::string> files;
  std::vector<std::string> settings;
};
void AddConfigOptions(CLI::App& command, ConfigSources& sources);
[[nodiscard]] Result<stages::Config> ReadConfig(const ConfigSources& sources);

// Text for the file a user named, or for standard output when the name is empty.
[[nodiscard]] Status WriteResult(const std::string& file, const std::string& text);

}  // namespace deepslam::tools
