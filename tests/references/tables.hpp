// Readers of tests/data/references: numbers as quad from their 25 digits.
#pragma once

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "references/quad.hpp"
#include "source_dir.hpp"

namespace assur::references {

inline std::vector<std::vector<Quad>> read_table(const std::string& file, std::size_t columns) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<std::vector<Quad>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<Quad> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.emplace_back(cell);
    if (row.size() != columns) throw std::runtime_error(file + ": " + std::to_string(columns) + " columns expected");
    rows.push_back(std::move(row));
  }
  return rows;
}

struct AndrewsRow {
  Quad beta;  // rad; beta' = 1 rad/s, beta'' = 0
  Vec<QuadJet> E, G, H;
};

// 72 rows: beta = 2 pi k / 72
inline std::vector<AndrewsRow> read_andrews(const std::string& source_dir = ASSUR_SOURCE_DIR) {
  std::vector<AndrewsRow> rows;
  for (const auto& v : read_table(source_dir + "/tests/data/references/andrews_kinematics.csv", 20)) {
    const auto point = [&v](std::size_t i) -> Vec<QuadJet> {  // x, y at i, rates at i + 6, accelerations at i + 12
      return {QuadJet{v[i], v[i + 6], v[i + 12]}, QuadJet{v[i + 1], v[i + 7], v[i + 13]}, QuadJet{}};
    };
    rows.push_back({v[1], point(2), point(4), point(6)});
  }
  return rows;
}

struct GoughRow {
  int posture;        // 1..40
  Vec<Quad> n, u, v;  // B1 - A1, and the platform's x and y axis
  double condition;   // of the Jacobian of 9 equations, in the maximum norm
};

inline std::vector<GoughRow> read_gough(const std::string& source_dir = ASSUR_SOURCE_DIR) {
  std::vector<GoughRow> rows;
  for (const auto& v : read_table(source_dir + "/tests/data/references/stewart_dietmaier40.csv", 11)) {
    rows.push_back({static_cast<int>(v[0]),
                    {v[1], v[2], v[3]},
                    {v[4], v[5], v[6]},
                    {v[7], v[8], v[9]},
                    static_cast<double>(v[10])});
  }
  return rows;
}

}  // namespace assur::references
