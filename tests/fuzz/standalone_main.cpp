// A driver for fuzz targets where the compiler has no libFuzzer. Runs every input of the corpus,
// then mutations of them for a time:
//
//   target [--seconds 60] [--seed n] [--slowest 10] corpus-folder-or-input...
//
// The seed is printed and, with the count printed at the end, makes the same inputs again. An input
// that crashes the target, or takes longer than --slowest seconds, is kept in
// fuzz-failure-<seed>-<count> in the working folder; given as an argument it is run alone.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

constexpr std::size_t longest_input = 1 << 16;

// What a signal handler needs: the current input and where to keep it.
const std::string* current = nullptr;
char kept_name[64] = "";

void say(const char* text) {
  if (write(STDOUT_FILENO, text, std::strlen(text)) < 0) {
    _exit(3);
  }
}

extern "C" void on_failure(int signal_number) {
  say(signal_number == SIGALRM ? "FAILED: too slow" : "FAILED: crashed");
  if (current != nullptr) {
    const int file = open(kept_name, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (file >= 0 && write(file, current->data(), current->size()) >= 0) {
      say("; the input is kept in ");
      say(kept_name);
    }
  }
  say("\n");
  _exit(2);
}

void catch_failures() {
  // On a stack of its own, so that an overflow of the stack is caught as well.
  static char stack[1 << 16];
  stack_t alternate{};
  alternate.ss_sp = stack;
  alternate.ss_size = sizeof stack;
  sigaltstack(&alternate, nullptr);
  struct sigaction action {};
  action.sa_handler = on_failure;
  action.sa_flags = SA_ONSTACK;
  for (const int number : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGALRM}) {
    sigaction(number, &action, nullptr);
  }
}

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class Mutator {
public:
  Mutator(const std::vector<std::string>& corpus, std::uint64_t seed)
      : corpus_(corpus), random_(seed) {
    for (const std::string& input : corpus) {
      collect_words(input);
    }
  }

  std::string next() {
    std::string input = pick(corpus_);
    for (std::size_t count = 1 + below(6); count > 0; --count) {
      mutate(input);
    }
    if (input.size() > longest_input) {
      input.resize(longest_input);
    }
    return input;
  }

private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }
  const std::string& pick(const std::vector<std::string>& from) { return from[below(from.size())]; }

  /// Words and signs of the corpus, to be put elsewhere.
  void collect_words(const std::string& input) {
    const auto is_word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
    };
    for (std::size_t i = 0; i < input.size();) {
      std::size_t end = i + 1;
      while (is_word(input[i]) && end < input.size() && is_word(input[end])) {
        ++end;
      }
      words_.push_back(input.substr(i, end - i));
      i = end;
    }
    std::sort(words_.begin(), words_.end());
    words_.erase(std::unique(words_.begin(), words_.end()), words_.end());
  }

  void mutate(std::string& input) {
    static const std::vector<std::string> hostile = {"nan",
                                                     "-inf",
                                                     ".inf",
                                                     "1e999",
                                                     "-1",
                                                     "9223372036854775808",
                                                     "1e-400",
                                                     "0",
                                                     "\t",
                                                     "\n",
                                                     "\r",
                                                     "%s",
                                                     "&a ",
                                                     "*a",
                                                     "<<: ",
                                                     "!!binary ",
                                                     "? ",
                                                     ": ",
                                                     "- ",
                                                     "[",
                                                     "]",
                                                     "{",
                                                     "}",
                                                     "'",
                                                     "\"",
                                                     "|",
                                                     ">",
                                                     "#",
                                                     "---\n",
                                                     "...\n",
                                                     "\xEF\xBB\xBF",
                                                     "\xFF",
                                                     std::string(1, '\0'),
                                                     "[[[[[[[[[[[[",
                                                     "((((((((((((",
                                                     "- - - - - - - ",
                                                     "%YAML 9.9\n",
                                                     "~",
                                                     "\xE2\x82\xAC"};
    const std::size_t at = below(input.size() + 1);
    const std::size_t length = std::min(below(32), input.size() - at);
    switch (below(9)) {
    case 0:
      if (at < input.size()) {
        input[at] = static_cast<char>(random_());
      }
      break;
    case 1:
      if (at < input.size()) {
        input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
      }
      break;
    case 2:
      input.erase(at, length);
      break;
    case 3:
      input.insert(at, input.substr(at, length));
      break;
    case 4:
      input.insert(at, pick(hostile));
      break;
    case 5:
      if (!words_.empty()) {
        input.insert(at, pick(words_));
      }
      break;
    case 6:
      if (!words_.empty()) {
        input.replace(at, length, pick(words_));
      }
      break;
    case 7: { // the head of this input, the tail of another
      const std::string& other = pick(corpus_);
      input = input.substr(0, at) + other.substr(below(other.size() + 1));
      break;
    }
    default: { // the same again and again
      const std::string part = below(2) == 0 ? pick(hostile) : input.substr(at, length);
      for (std::size_t count = below(200); count > 0 && input.size() < longest_input; --count) {
        input.insert(at, part);
      }
    }
    }
  }

  const std::vector<std::string>& corpus_;
  std::vector<std::string> words_;
  std::mt19937_64 random_;
};

} // namespace

int main(int argc, char** argv) {
  double seconds = 60;
  unsigned slowest = 10;
  std::uint64_t seed = std::random_device{}();
  std::vector<std::filesystem::path> paths;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--seconds" && i + 1 < argc) {
      seconds = std::atof(argv[++i]);
    } else if (argument == "--seed" && i + 1 < argc) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (argument == "--slowest" && i + 1 < argc) {
      slowest = static_cast<unsigned>(std::atoi(argv[++i]));
    } else {
      paths.emplace_back(argument);
    }
  }
  std::vector<std::string> corpus;
  bool has_folder = false;
  for (const auto& path : paths) {
    if (std::filesystem::is_directory(path)) {
      has_folder = true;
      std::vector<std::filesystem::path> inputs(std::filesystem::directory_iterator{path}, {});
      std::sort(inputs.begin(), inputs.end()); // the same order, so the same inputs, everywhere
      for (const auto& input : inputs) {
        corpus.push_back(read(input));
      }
    } else {
      corpus.push_back(read(path));
    }
  }
  if (corpus.empty()) {
    std::printf("usage: %s [--seconds n] [--seed n] [--slowest n] corpus-folder-or-input...\n",
                argv[0]);
    return 1;
  }
  std::printf("seed %llu, %zu inputs in the corpus\n", static_cast<unsigned long long>(seed),
              corpus.size());
  std::fflush(stdout);
  catch_failures();

  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto elapsed = [&](Clock::time_point since) {
    return std::chrono::duration<double>(Clock::now() - since).count();
  };
  double worst = 0;
  std::size_t count = 0;
  const auto run = [&](const std::string& input) {
    std::snprintf(kept_name, sizeof kept_name, "fuzz-failure-%llu-%zu",
                  static_cast<unsigned long long>(seed), count);
    current = &input;
    const auto since = Clock::now();
    alarm(slowest);
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    alarm(0);
    current = nullptr;
    worst = std::max(worst, elapsed(since));
    ++count;
  };
  for (const std::string& input : corpus) {
    run(input);
  }
  Mutator mutator(corpus, seed);
  while (has_folder && elapsed(begin) < seconds) {
    run(mutator.next());
  }
  std::printf("%zu inputs in %.1f s, the slowest in %.3f s: none failed\n", count, elapsed(begin),
              worst);
  return 0;
}
