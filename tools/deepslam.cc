// `deepslam`: captures to maps. docs and design of the commands: README.md.
#include <array>

#include "command_line.h"
#include "other_program.h"

int main(int argc, char** argv) {
  using namespace deepslam::tools;  // NOLINT(google-build-using-namespace): the table below is all
                                    // of main
  if (IsForOtherProgram({argv + 1, argv + argc})) return StartOtherProgram(argv);
  constexpr std::array<AddCommand, 13> kCommands = {AddRun,
                                                    AddBatch,
                                                    AddBatchSummary,
                                                    AddBatchWorker,
                                                    AddStatus,
                                                    AddConfig,
                                                    AddDoctor,
                                                    AddValidate,
                                                    AddExpand,
                                                    AddConvert,
                                                    AddLibrary,
                                                    NameOtherCommands,
                                                    AddVersion};
  return RunCommandLine(argc, argv, kCommands);
}
