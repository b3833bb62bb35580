#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// Tables in a paper's own rows and columns, its figures beside ours.
namespace insitu::bench::paper {

/// A number with the pattern that it is printed by, or words; empty: "-".
class Cell {
public:
  Cell() = default;
  Cell(double value, const char* pattern = "%.3g");
  Cell(std::int64_t count);
  Cell(std::string words) : text_(std::move(words)) {}
  Cell(const char* words) : text_(words) {}

  /// As a person reads it, and as programs do: all digits, and nothing where there is no figure.
  const std::string& text() const { return text_; }
  const std::string& exact() const { return is_number_ ? exact_ : text_; }
  bool is_number() const { return is_number_; }

private:
  std::string text_, exact_;
  bool is_number_ = false;
};

struct Table {
  std::string key;     ///< of its file
  std::string title;   ///< which table of the paper
  std::string caption; ///< units, what was normalised, what stands in for what
  std::string label;   ///< of the rows' names
  std::vector<std::string> columns;
  struct Row {
    std::string
        section; ///< rows of one section stand together under its name: "here", "paper", ...
    std::string name;
    std::vector<Cell> cells;
  };
  std::vector<Row> rows;
  std::vector<std::string> left_out;

  void add(std::string section, std::string name, std::vector<Cell> cells) {
    rows.push_back({std::move(section), std::move(name), std::move(cells)});
  }
};

/// All tables of a paper, and further files by name: plots.
struct Tables {
  std::string title;
  std::vector<std::string> notes; ///< on all of them
  std::vector<Table> tables;
  std::vector<std::pair<std::string, std::string>> files;
  bool failed = false; ///< a check within did
};

/// The title and the notes; and a table.
std::string heading(const Tables& tables);
std::string text(const Table& table);
/// Columns: section, row, then the table's.
std::string csv(const Table& table);
std::string json(const Tables& tables);

} // namespace insitu::bench::paper
