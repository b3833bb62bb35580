#include "runs/foam_labels.h"

#include <cctype>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>

#include "file_error.h"

namespace insitu_replay {

namespace {

/// Goes through a file's words, without comments.
class Words {
public:
  explicit Words(const std::string& path) : path_(path) {
    std::ifstream in(path, std::ios::binary);
    if (!in)
      throw FileError(path, "cannot be opened");
    text_.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }

  /// A word, or one of ( ) { } ;.
  std::string next() {
    skip();
    if (at_ >= text_.size())
      throw FileError(path_, "ends within a list of labels");
    const std::size_t begin = at_++;
    if (text_[begin] == '"')
      while (at_ < text_.size() && text_[at_++] != '"') {
      }
    else if (!is_sign(text_[begin]))
      while (at_ < text_.size() && !is_sign(text_[at_]) &&
             !std::isspace(static_cast<unsigned char>(text_[at_])))
        ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::int64_t number(const std::string& word) const {
    std::int64_t out = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
    if (error != std::errc() || end != word.data() + word.size())
      throw FileError(path_, "'" + word + "' stands where a label is expected");
    return out;
  }

  /// Labels as bytes behind an opening bracket.
  void bytes(std::size_t size, std::vector<std::int64_t>& out) {
    if (out.size() > (text_.size() - at_) / size)
      throw FileError(path_, "ends within its " + std::to_string(out.size()) + " labels");
    for (std::int64_t& label : out) {
      std::int32_t small = 0;
      std::memcpy(size == 4 ? static_cast<void*>(&small) : &label, text_.data() + at_, size);
      if (size == 4)
        label = small;
      at_ += size;
    }
  }

  std::size_t size() const { return text_.size(); }

private:
  static bool is_sign(char c) { return std::strchr("(){};", c) != nullptr && c != '\0'; }

  void skip() {
    for (;;) {
      while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])))
        ++at_;
      const std::string two = text_.substr(at_, 2);
      if (two != "//" && two != "/*")
        return;
      const std::size_t end = text_.find(two == "//" ? "\n" : "*/", at_ + 2);
      at_ = end == std::string::npos ? text_.size() : end + (two == "//" ? 1 : 2);
    }
  }

  const std::string& path_;
  std::string text_;
  std::size_t at_ = 0;
};

} // namespace

std::vector<std::int64_t> read_foam_labels(const std::string& path) {
  Words words(path);
  bool binary = false;
  std::size_t bytes = 4;
  std::string word = words.next();
  if (word == "FoamFile") {
    for (std::string key = words.next(); key != "}"; key = words.next()) {
      if (key == "{")
        continue;
      const std::string value = words.next();
      binary = binary || (key == "format" && value == "binary");
      if (key == "arch" && value.find("label=64") != std::string::npos)
        bytes = 8;
      if (key == "arch" && value.find("MSB") != std::string::npos)
        throw FileError(path, "has labels of another byte order");
      for (word = value; word != ";";)
        word = words.next();
    }
    word = words.next();
  }
  const std::int64_t count = words.number(word);
  if (count < 0 || std::size_t(count) > (std::size_t(1) << 31))
    throw FileError(path, "tells " + word + " labels");
  const std::string sign = words.next();
  if (sign == "{") // all alike
    return std::vector<std::int64_t>(std::size_t(count), words.number(words.next()));
  if (sign != "(")
    throw FileError(path, "'" + sign + "' stands where a list is expected to begin");
  if (std::size_t(count) > words.size())
    throw FileError(path, "ends within its " + std::to_string(count) + " labels");
  std::vector<std::int64_t> out(static_cast<std::size_t>(count));
  if (binary)
    words.bytes(bytes, out);
  else
    for (std::int64_t& label : out)
      label = words.number(words.next());
  return out;
}

} // namespace insitu_replay
