// Stands in for libFuzzer: runs the target that CLOTHID_FUZZ_TARGET names on every file of a folder, then on inputs
// that are made of these.
//
//   clothid_fuzz FOLDER [NUM_NEW]
//
// The same folder gives the same inputs. The one that ends the process is left in fuzz_TARGET.input.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);  // fuzz_main.cc

namespace {

constexpr std::size_t kLongest = 4096;  // bytes, of a new input

// For the signal handler alone.
std::string current_input, finding_path;

void KeepInput(int signal) {
  const int file = open(finding_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file >= 0 && write(file, current_input.data(), current_input.size()) >= 0) close(file);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void RunTarget(std::string input) {
  current_input = std::move(input);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(current_input.data()), current_input.size());
}

std::vector<std::string> ReadFolder(const std::filesystem::path& folder) {
  std::vector<std::string> inputs;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  std::sort(inputs.begin(), inputs.end());
  return inputs;
}

// New inputs: known ones with a few edits each.
class Mutator {
 public:
  explicit Mutator(const std::vector<std::string>& known) : known_(known) {}

  std::string Next() {
    std::string input = Choose(known_);
    for (std::size_t edits = 1 + Below(4); edits > 0; --edits) Edit(&input);
    input.resize(std::min(input.size(), kLongest));
    return input;
  }

 private:
  std::size_t Below(std::size_t end) { return generator_() % end; }
  template <typename Container>
  const typename Container::value_type& Choose(const Container& items) {
    return items[Below(items.size())];
  }

  // A place in `text` and a length, short ones more often.
  std::pair<std::size_t, std::size_t> Span(std::string_view text) {
    const std::size_t begin = Below(text.size() + 1), most = std::size_t{1} << Below(9);
    return {begin, std::min(text.size() - begin, Below(most) + 1)};
  }

  void Edit(std::string* input) {
    static const std::vector<std::string> tokens = {
        "0",   "-1", "1e999", "nan", "4294967296", "\"", "[", "}", ",", "\n", std::string(1, '\0'), "\xff\xff\xff\xff",
        "\x7f"};
    const auto [begin, length] = Span(*input);
    switch (Below(6)) {
      case 0:  // another byte
        if (begin < input->size()) (*input)[begin] = static_cast<char>(Below(256));
        break;
      case 1:  // another bit
        if (begin < input->size()) (*input)[begin] = static_cast<char>((*input)[begin] ^ (1 << Below(8)));
        break;
      case 2:
        input->erase(begin, length);
        break;
      case 3:
        input->insert(begin, input->substr(begin, length));
        break;
      case 4:
        input->replace(begin, length, Choose(tokens));
        break;
      default: {
        const std::string& other = Choose(known_);
        const auto [from, count] = Span(other);
        input->replace(begin, length, other.substr(from, count));
      }
    }
  }

  const std::vector<std::string>& known_;
  std::mt19937_64 generator_{1};
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: clothid_fuzz FOLDER [NUM_NEW]\n";
    return 1;
  }
  const char* target = std::getenv("CLOTHID_FUZZ_TARGET");
  finding_path = "fuzz_" + std::string(target != nullptr ? target : "") + ".input";
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGALRM}) std::signal(signal, KeepInput);
  const std::vector<std::string> known = ReadFolder(argv[1]);
  for (const std::string& input : known) RunTarget(input);
  const int num_new = argc == 3 && !known.empty() ? std::atoi(argv[2]) : 0;
  Mutator mutator(known);
  for (int i = 0; i < num_new; ++i) {
    alarm(10);  // s, more than any input may take
    RunTarget(mutator.Next());
  }
  std::cout << known.size() << " inputs, " << num_new << " new ones\n";
  return known.empty() ? 1 : 0;
}
