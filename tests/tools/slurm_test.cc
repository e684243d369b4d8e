// The scripts of tools/slurm without Slurm: an `sbatch` that runs jobs at once and a program that writes down its
// arguments stand in. The last test runs fits under a real Slurm where it is installed; tools/slurm/test does
// landscapes.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/tool_test.h"

namespace clothid::slurm_test {
namespace {

namespace fs = std::filesystem;

constexpr char kSlurm[] = CLOTHID_SOURCE_DIR "/tools/slurm";

// Gives an array the id 12 and any other job 13.
constexpr char kSbatch[] = R"(#!/usr/bin/env bash
set -euo pipefail
printf '%s\n' "$@" >>sbatch_arguments
array=
while [[ "$1" == -* ]]; do
  [[ "$1" != --array=* ]] || array=${1#--array=} array=${array%%%*}
  shift
done
if [[ -z "$array" ]]; then
  bash "$@" >>last_job || true
  echo 13
  exit
fi
export SLURM_CPUS_PER_TASK=2
for range in ${array//,/ }; do
  for ((i = ${range%-*}; i <= ${range#*-}; ++i)); do SLURM_ARRAY_TASK_ID=$i bash "$@" || true; done
done
echo '12;name_of_the_cluster'
)";

// Its last argument is the folder of its output. The first file of a fit and of a shard are its results. It fails for
// the recording bad.bin.
constexpr char kProgram[] = R"(#!/usr/bin/env bash
if [[ "$2" == bad.bin ]]; then echo "bad.bin: line 3" >&2; exit 2; fi
mkdir -p "${!#}"
touch "${!#}/plan.json" "${!#}/result.json"
printf '%s\n' "$@" >"${!#}/arguments"
printf '%s' "$OMP_NUM_THREADS" >"${!#}/omp_num_threads"
)";

std::string Lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class SlurmTest : public ToolTest {
 protected:
  SlurmTest() {
    fs::create_directory(folder() / "bin");
    WriteProgram("bin/sbatch", kSbatch);
    WriteProgram("program", kProgram);
  }

  void WriteProgram(const std::string& name, const std::string& text) const {
    WriteBytes(folder() / name, text);
    fs::permissions(folder() / name, fs::perms::owner_all);
  }

  std::string Call(const std::string& script, const std::string& arguments) const {
    return "PATH=\"$PWD/bin:$PATH\" '" + std::string(kSlurm) + "/" + script + "' " + arguments;
  }
  std::string Submit(const std::string& arguments) const {
    return Call("submit", "--landscape ./program " + arguments);
  }
  std::string SubmitFits(const std::string& arguments) const {
    return Call("submit_fits", "--identify ./program " + arguments);
  }

  // Task 1 of an array of 3 with `commands`, in the folder out.
  std::string Task(const std::string& commands) const {
    fs::create_directory(folder() / "out");
    WriteBytes(folder() / "out" / "commands", commands);
    return "PATH=\"$PWD/bin:$PATH\" SLURM_ARRAY_JOB_ID=12 SLURM_ARRAY_TASK_ID=1 bash '" + std::string(kSlurm) +
           "/job.sbatch' '" + kSlurm + "/array_task' 3 out";
  }

  void WriteRecordings(const std::vector<std::string>& names) const {
    for (const std::string& name : names) WriteBytes(folder() / name, "");
  }

  // The jobs that `sbatch` was given since the last call, an argument per line.
  std::string SbatchArguments() const {
    const std::string arguments = ReadBytes(folder() / "sbatch_arguments");
    fs::remove(folder() / "sbatch_arguments");
    return arguments;
  }
};

TEST_F(SlurmTest, ArgumentsReachEveryTaskUnchanged) {
  const ToolResult result =
      Run("OMP_NUM_THREADS=8 " +
          Submit(R"(3%2 'of mine; 50 %a' --time=1:00:00 -- --target 'a b;$HOME*.bin' --sweep "a=1,2;b='3'" '')"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const fs::path output = folder() / "of mine; 50 %a";
  for (const std::string task : {"0", "1", "2"}) {
    const fs::path shard = output / ("shard_" + task);
    EXPECT_EQ(ReadBytes(shard / "arguments"),
              Lines({"--target", "a b;$HOME*.bin", "--sweep", "a=1,2;b='3'", "", "--shard", task + "/3", "--resume",
                     "--threads", "2", "--output", shard.string()}));
    EXPECT_EQ(ReadBytes(shard / "omp_num_threads"), "1");
  }
  EXPECT_EQ(ReadBytes(output / "merged" / "arguments"), Lines({"merge", output / "shard_0", output / "shard_1",
                                                               output / "shard_2", "--output", output / "merged"}));
}

TEST_F(SlurmTest, MergeWaitsForTheArrayAndBothIdsArePrinted) {
  const ToolResult result = Run(Submit("3%2 out --time=1:00:00 -- --target motion.bin"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("array 12: 3 of 3 commands", 0), 0) << result.out;
  EXPECT_NE(result.out.find("\nlast 13: "), std::string::npos) << result.out;
  const std::string arguments = SbatchArguments();
  const size_t merge = arguments.find("--parsable", 1);
  ASSERT_NE(merge, std::string::npos) << arguments;
  EXPECT_LT(arguments.find("--array=0-2%2\n"), merge) << arguments;
  EXPECT_GT(arguments.find("--dependency=afterany:12\n"), merge) << arguments;
  EXPECT_LT(arguments.find("--time=1:00:00\n"), merge) << arguments;
  EXPECT_NE(arguments.find("--time=1:00:00\n", merge), std::string::npos) << arguments;
}

TEST_F(SlurmTest, BadSubmissionsAreRefused) {
  ExpectRefused(Submit("0 out -- --target motion.bin"), 1, "N is '0'");
  ExpectRefused(Submit("3.5 out -- --target motion.bin"), 1, "N is '3.5'");
  ExpectRefused(Submit("3"), 1, "usage");
  ExpectRefused(Submit("--time=10 3 out -- --target motion.bin"), 1, "usage");
  ExpectRefused(Submit("3 out --target motion.bin"), 1, "after --");
  ExpectRefused(Submit("3 out --array=0-9 -- --target motion.bin"), 1, "--array=0-9");
  for (const std::string flag : {"--shard", "--resume", "-threads=4", "--output=here"})
    ExpectRefused(Submit("3 out -- --target motion.bin " + flag), 1, flag);
  ExpectRefused(std::string(kSlurm) + "/submit --landscape ./nothing 3 out -- --target motion.bin", 1, "./nothing");
}

TEST_F(SlurmTest, AFolderGoesOnWithItsOwnScanOnly) {
  ExpectSuccess(Submit("3 out -- --target motion.bin"));
  ExpectSuccess(Submit("3%1 out --time=10 -- --target motion.bin"));
  ExpectRefused(Submit("2 out -- --target motion.bin"), 1, "out holds other commands");
  ExpectRefused(Submit("3 out -- --target other.bin"), 1, "out holds other commands");
}

TEST_F(SlurmTest, AFolderInTheQueueIsNotSubmittedAgain) {
  ExpectSuccess(Submit("3 out -- --target motion.bin"));
  WriteProgram("bin/squeue", "#!/bin/sh\n[ \"$*\" != '--noheader --jobs=12' ] || echo 12 PENDING\n");
  ExpectRefused(Submit("3 out -- --target motion.bin"), 1, "array 12 of out is still in the queue");
}

TEST_F(SlurmTest, EveryRecordingIsFittedInAFolderOfItsOwn) {
  WriteRecordings({"b a;$HOME.motion.bin", "a.bin", "c.motion.bin"});
  ExpectSuccess(
      SubmitFits(R"(--judge 9%2 out --time=5 -- 'b a;$HOME.motion.bin' a.bin c.motion.bin -- --fit 'mu, drag')"));
  const fs::path fits = folder() / "out" / "fits";
  EXPECT_EQ(ReadBytes(fits / "001_b_a__HOME" / "arguments"),
            Lines({"--target", "b a;$HOME.motion.bin", "--fit", "mu, drag", "--resume", "--threads", "2", "--output",
                   fits / "001_b_a__HOME"}));
  EXPECT_TRUE(fs::exists(fits / "002_a" / "result.json"));
  EXPECT_TRUE(fs::exists(fits / "003_c" / "result.json"));
  EXPECT_EQ(ReadBytes(folder() / "last_job"), "3 of 3 complete\n");
  EXPECT_EQ(ReadBytes(folder() / "out" / "judged" / "arguments"),
            Lines({"--repeat", "--target", fits, "--output", folder() / "out" / "judged"}));
  EXPECT_NE(SbatchArguments().find("--array=0-2%2\n"), std::string::npos);
}

TEST_F(SlurmTest, OnlyWhatIsIncompleteIsSubmittedAgain) {
  WriteRecordings({"a.bin", "bad.bin", "c.bin", "d.bin", "e.bin", "f.bin"});
  const std::string submit = SubmitFits("--judge 6 out -- a.bin bad.bin c.bin d.bin e.bin f.bin");
  Run(submit);
  EXPECT_NE(SbatchArguments().find("--array=0-5\n"), std::string::npos);
  const std::string last = "missing fits/002_bad: exit code 2: bad.bin: line 3\n5 of 6 complete\n";
  EXPECT_EQ(ReadBytes(folder() / "last_job"), last);
  EXPECT_FALSE(fs::exists(folder() / "out" / "judged"));

  const fs::path fits = folder() / "out" / "fits";
  fs::remove(fits / "004_d" / "result.json");
  fs::remove(fits / "006_f" / "exit_code");  // was killed
  fs::remove_all(fits / "005_e");
  EXPECT_EQ(Run(Call("status", "out")).exit_code, 1);
  Run(submit);
  EXPECT_NE(SbatchArguments().find("--array=1,3-5\n"), std::string::npos);
  EXPECT_EQ(ReadBytes(folder() / "last_job"), last + last);

  WriteProgram("program", "#!/bin/sh\nfor o; do :; done\nmkdir -p $o\ntouch $o/result.json\nexit 4\n");
  Run(submit);
  EXPECT_NE(SbatchArguments().find("--array=1\n"), std::string::npos);
  EXPECT_EQ(ReadBytes(fits / "002_bad" / "exit_code"), "4\n");
  EXPECT_TRUE(fs::exists(folder() / "out" / "judged"));
  // Nothing is left, but what comes last.
  Run(submit);
  EXPECT_EQ(SbatchArguments().find("--array"), std::string::npos);
  EXPECT_EQ(Run(Call("status", "out")).out, "6 of 6 complete\n");
}

TEST_F(SlurmTest, RecordingsCanBeAddedAndShareTasks) {
  WriteRecordings({"a.bin", "b.bin", "c.bin", "d.bin", "e.bin"});
  ExpectSuccess(SubmitFits("2 out -- a.bin b.bin c.bin -- --fit mu"));
  EXPECT_NE(SbatchArguments().find("--array=0-1\n"), std::string::npos);
  EXPECT_EQ(Run(Call("status", "out")).out, "3 of 3 complete\n");
  ExpectSuccess(SubmitFits("2 out -- a.bin b.bin c.bin d.bin -- --fit mu"));
  EXPECT_NE(SbatchArguments().find("--array=1\n"), std::string::npos);
  EXPECT_EQ(Run(Call("status", "out")).out, "4 of 4 complete\n");
  ExpectRefused(SubmitFits("2 out -- a.bin b.bin c.bin e.bin -- --fit mu"), 1, "other commands");
  ExpectRefused(SubmitFits("2 out -- a.bin b.bin c.bin -- --fit mu,drag"), 1, "other commands");
}

TEST_F(SlurmTest, BadFitsAreRefused) {
  WriteRecordings({"a.bin", "b.bin", "a,b.bin"});
  ExpectRefused(SubmitFits("0 out -- a.bin"), 1, "N is '0'");
  ExpectRefused(SubmitFits("2 out"), 1, "no recordings");
  ExpectRefused(SubmitFits("2 out -- -- --fit mu"), 1, "no recordings");
  ExpectRefused(SubmitFits("2 out -- a.bin nothing.bin"), 1, "nothing.bin");
  ExpectRefused(SubmitFits("2 out -- a.bin ./a.bin"), 1, "./a.bin' is given twice");
  ExpectRefused(SubmitFits("2 out -- a,b.bin"), 1, "comma");
  ExpectRefused(SubmitFits("2 out -- a.bin -- --target=b.bin"), 1, "--target=b.bin");
  ExpectRefused(SubmitFits("--array=1 2 out -- a.bin"), 1, "usage");
}

TEST_F(SlurmTest, CommandsOfAFileRunInTheirFolders) {
  WriteBytes(folder() / "commands",
             "# seeds\nseeds/1/result.json ./program --seed 1 'a b' \"$SLURM_CPUS_PER_TASK\"\n\n"
             "seeds/2/arguments ./program --seed 2  # the second\nseeds/3/other ./program\n");
  Run(Call("submit_array", "8 out commands -- ./program last"));
  const fs::path seeds = folder() / "out" / "seeds";
  EXPECT_EQ(ReadBytes(seeds / "1" / "arguments"), Lines({"--seed", "1", "a b", "2", "--output", seeds / "1"}));
  EXPECT_EQ(ReadBytes(seeds / "2" / "arguments"), Lines({"--seed", "2", "--output", seeds / "2"}));
  EXPECT_EQ(ReadBytes(folder() / "last_job"), "missing seeds/3: exit code 1: there is no other\n2 of 3 complete\n");
  EXPECT_FALSE(fs::exists(folder() / "last"));
}

TEST_F(SlurmTest, BadCommandsAreRefused) {
  const auto expect_refused = [this](const std::string& commands, const std::string& culprit) {
    WriteBytes(folder() / "commands", commands);
    ExpectRefused(Call("submit_array", "8 out commands"), 1, culprit);
  };
  expect_refused("\n# nothing\n", "commands: there is no command");
  expect_refused("a/result.json\n", "'a/result.json', expected FOLDER/RESULT COMMAND");
  expect_refused("result.json ./program\n", "expected FOLDER/RESULT COMMAND");
  expect_refused("../a/result.json ./program\n", "expected FOLDER/RESULT COMMAND");
  expect_refused("/a/result.json ./program\n", "expected FOLDER/RESULT COMMAND");
  expect_refused("a/result.json ./program 'a\n", "words as a shell reads them");
  expect_refused("a/x ./program\na/y ./program\n", "two commands have the folder a");
  ExpectRefused(Call("submit_array", "8 out nothing"), 1, "'nothing'");
}

TEST_F(SlurmTest, ExitCodeIsThatOfTheProgram) {
  WriteProgram("program", "#!/bin/sh\nexit 2\n");
  EXPECT_EQ(Run(Task("a/x ./program\nb/x ./program\n")).exit_code, 2);
}

TEST_F(SlurmTest, ACommandThatFailsDoesNotHoldUpTheNext) {
  const std::string five =
      "a/result.json ./program --target a.bin\nb/result.json ./program --target bad.bin\n"
      "c/result.json ./program\nd/result.json ./program\ne/result.json ./program\n";
  EXPECT_EQ(Run(Task(five)).exit_code, 2);
  EXPECT_TRUE(fs::exists(folder() / "out" / "e" / "exit_code"));
  EXPECT_FALSE(fs::exists(folder() / "out" / "a")) << "task 1 of 3 has the commands 1 and 4";
}

// The signal comes while the program runs, and the program goes on.
TEST_F(SlurmTest, TaskThatRunsOutOfTimeIsRequeued) {
  WriteProgram("bin/scontrol", "#!/bin/sh\necho \"$@\" >>scontrol_arguments\n");
  const std::string signals = "kill -USR1 $PPID\nsleep 0.2\nexit 1\n";
  const std::string commands = "a/x ./program\nb/x ./program\n";
  WriteProgram("program", "#!/bin/sh\nmkdir -p out/b\necho a cell >>out/b/cells\n" + signals);
  EXPECT_EQ(Run(Task(commands)).exit_code, 1);
  EXPECT_EQ(ReadBytes(folder() / "scontrol_arguments"), "requeue 12_1\n");

  // Nothing finished in all of its time: it never would be.
  WriteProgram("program", "#!/bin/sh\n" + signals);
  const ToolResult result = Run(Task(commands));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.err.find("raise --time"), std::string::npos) << result.err;
  EXPECT_EQ(ReadBytes(folder() / "scontrol_arguments"), "requeue 12_1\n");
}

// tools/slurm/test_fits under a real Slurm: fits that are killed and requeued end in the bytes of plain ones.
TEST_F(SlurmTest, KilledFitsEndInTheSameBytes) {
  if (Run("sh -c 'PATH=\"$PATH:/usr/sbin:/sbin\"; command -v slurmctld && command -v munged'").exit_code != 0) {
    GTEST_SKIP() << "Slurm is not installed";
  }
  const ToolResult result = Run(std::string(kSlurm) + "/test_fits --programs '" CLOTHID_BINARY_DIR "'");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("12 fits as one after the other"), std::string::npos) << result.out << result.err;
}

}  // namespace
}  // namespace clothid::slurm_test
