// `deepslam-tools`: every command there is, those that make worlds, training data and figures among
// them. People type `deepslam` (other_program.h).
#include <array>

#include "command_line.h"

int main(int argc, char** argv) {
  using namespace deepslam::tools;  // NOLINT(google-build-using-namespace): the table below is all
                                    // of main
  constexpr std::array<AddCommand, 16> kCommands = {AddRun,
                                                    AddBatch,
                                                    AddBatchSummary,
                                                    AddBatchWorker,
                                                    AddStatus,
                                                    AddConfig,
                                                    AddDoctor,
                                                    AddValidate,
                                                    AddExpand,
                                                    AddConvert,
                                                    AddEval,
                                                    AddSynth,
                                                    AddLibrary,
                                                    AddForms,
                                                    AddPriors,
                                                    AddVersion};
  return RunCommandLine(argc, argv, kCommands);
}
