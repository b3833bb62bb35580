#pragma once

/// Figures quoted from the papers, by table; negative: none.
namespace insitu::bench::paper {

constexpr double oom = -1.0, na = -2.0;

// Morrical et al. 2020. Columns: fusion, jets, agul-t, jpn-t, agul-w, jpn-h.

/// By accel::Method; the paper's tables give the two kinds of shared faces one row: planar ones for
/// tetrahedra, bilinear ones for the others.
constexpr const char* morrical_rows[] = {"cuda-bvh", "rtx-bvh", "rtx-rep-faces", "rtx-shrd-faces"};

/// Table 1, Turing: megabytes, or million faces.
struct MemoryFigures {
  int method;
  const char* row;
  double of[6];
};
constexpr MemoryFigures morrical_memory[] = {
    {0, "final", {466, 844, 1900, 3100, 1300, 1000}},
    {1, "peak (no p/s)", {656, 2100, 5700, 9600, 2600, 1600}},
    {1, "peak (w/ p/s)", {504, 1100, 2100, 4400, 1800, 1400}},
    {1, "final", {464, 754, 1700, 3100, 1800, 1300}},
    {2, "faces an element", {11.9, 49.1, 143, 249, na, na}},
    {2, "peak (no p/s)", {1600, 5900, 16900, oom, na, na}},
    {2, "peak (w/ p/s)", {1200, 2300, 6100, 11000, na, na}},
    {2, "final", {770, 1800, 5400, 10700, na, na}},
    {3, "faces an element", {5.99, 24.7, 72, 134, 58, 52}},
    {3, "peak (no p/s)", {960, 3300, 9300, 16900, 9000, 8200}},
    {3, "peak (w/ p/s)", {846, 1700, 4400, 7200, 4000, 3700}},
    {3, "final", {643, 1400, 3900, 6800, 3800, 3300}}};

/// Tables 2 and 3: million samples a second; table 4: frames a second. Of the card without ray
/// tracing hardware, and of one with it; four rows a card, by method.
struct RateFigures {
  const char* table;
  const char* machine;
  int method;
  double of[6];
};
constexpr RateFigures morrical_rates[] = {
    {"2", "Titan V", 0, {89.7, 1550, 971, 461, 358.7, 183.0}},
    {"2", "Titan V", 1, {91.8, 1050, 741, 373, 179.6, 200.5}},
    {"2", "Titan V", 2, {34.7, 407, oom, oom, na, na}},
    {"2", "Titan V", 3, {59.7, 689, 397, oom, 238.6, 150.1}},
    {"2", "Titan RTX", 0, {84.5, 1390, 813, 386, 188.7, 202.5}},
    {"2", "Titan RTX", 1, {145, 1670, 1430, 736, 178.3, 259.5}},
    {"2", "Titan RTX", 2, {377, 1780, 1700, 1400, na, na}},
    {"2", "Titan RTX", 3, {537, 2400, 2400, 2000, 1900, 1300}},
    {"3", "Titan V", 0, {36.4, 82.4, 83.8, 70.3, 130.1, 73.4}},
    {"3", "Titan V", 1, {30.2, 108, 83.6, 68.6, 80.3, 69.8}},
    {"3", "Titan V", 2, {23.7, 81.5, oom, oom, na, na}},
    {"3", "Titan V", 3, {35.1, 101, 63.6, oom, 78.5, 51.1}},
    {"3", "Titan RTX", 0, {31.4, 90.1, 77.5, 62.8, 85.2, 75.5}},
    {"3", "Titan RTX", 1, {37.1, 111, 99.5, 83.9, 96.2, 80.2}},
    {"3", "Titan RTX", 2, {99, 243, 188, 138, na, na}},
    {"3", "Titan RTX", 3, {116, 268, 196, 150, 195.8, 150.9}},
    {"4", "Titan V", 0, {13.98, 27.64, 24.62, 5.15, 6.68, 1.66}},
    {"4", "Titan V", 1, {5.74, 13.7, 17.3, 3.07, 7.35, 2.13}},
    {"4", "Titan V", 2, {5.82, 8.79, oom, oom, na, na}},
    {"4", "Titan V", 3, {9.4, 13.2, oom, oom, 11.2, 2.22}},
    {"4", "Titan RTX", 0, {12.7, 22.6, 26.0, 4.59, 3.87, 2.05}},
    {"4", "Titan RTX", 1, {4.97, 8.39, 16.2, 2.55, 6.66, 3.36}},
    {"4", "Titan RTX", 2, {27.7, 31.7, 37.8, 8.20, na, na}},
    {"4", "Titan RTX", 3, {42.0, 38.6, 48.8, 10.1, 48.4, 12.1}}};

/// Table 5.
struct PeerFigures {
  const char* renderer;
  double of[6];
};
constexpr PeerFigures morrical_peers[] = {{"ParaView", {0.80, 2.1, 0.04, 0.03, 0.04, 0.04}},
                                          {"OSPRay", {1.64, 0.76, 0.58, 0.48, 0.93, 1.94}},
                                          {"IndeX", {40.9, 6.7, na, 8.10, na, 7.83}},
                                          {"theirs", {41.9, 39.0, 48.8, 10.0, 47.3, 11.5}}};

// Rathke et al. 2015: data sets, millions of cells, and million rays a second. The Xeon node has
// two E5-2687W v3 of ten cores each.

constexpr double rathke_cores = 20;

struct RathkeFigures {
  const char* data_set;
  double millions;
  const char* cells;
  double spmd, packeted; ///< table 1
  double of_group[6];    ///< table 2: groups of 1, 4, 8, 16, 24, 32
  double iso, dvr;       ///< table 4, Xeon node
  double phi_iso, phi_dvr;
};
constexpr int rathke_groups[] = {1, 4, 8, 16, 24, 32};
constexpr RathkeFigures rathke_figures[] = {
    {"Bucky",
     0.177,
     "tets",
     68.9,
     103.2,
     {54.6, 56.5, 56.0, 54.9, 52.4, 49.6},
     103.2,
     54.9,
     365.0,
     25.3},
    {"Jets", 1, "tets", 79.9, 92.0, {5.2, 5.2, 5.4, 5.3, 5.2, 5.1}, 92.0, 5.3, 282.0, 9.7},
    {"T-jet", 12, "tets", 90.7, 109.4, {4.0, 4.4, 4.5, 4.5, 4.4, 4.3}, 109.4, 4.5, 418.9, 9.8},
    {"SF1", 14, "tets", 60.2, 78.7, {9.9, 9.6, 9.5, 9.0, 8.7, 8.4}, 78.7, 9.0, 190.8, 12.1},
    {"Earthquake",
     47,
     "hexes",
     14.1,
     46.3,
     {12, 13.7, 15.9, 17.7, 17.8, 17.3},
     46.3,
     17.7,
     101.6,
     16.7}};

/// Table 3: Jets, by step; in the paper's units 10 is the step of table 2.
struct StepFigures {
  double step, of_group[6];
};
constexpr StepFigures rathke_steps[] = {
    {2.5, {2.4, 2.9, 3.1, 3.2, 3.3, 3.3}},  {5, {3.5, 3.9, 4.1, 4.1, 4.1, 4.0}},
    {7.5, {4.5, 4.6, 4.7, 4.7, 4.7, 4.5}},  {10, {5.2, 5.3, 5.4, 5.3, 5.2, 4.9}},
    {12.5, {5.9, 6.0, 6.0, 5.8, 5.7, 5.5}}, {15, {6.5, 6.5, 6.5, 6.3, 6.1, 6.0}}};

// Zellmann et al. 2023. Data sets: TAC Molecular Cloud, LANL Impact, NASA Landing Gear, NASA
// Exajet.

/// Table 1: millions, but thousands of gridlets; those of TAC are not all legible to us.
struct DualFigures {
  const char* model;
  double vertices, pyramids, wedges, hexahedra, elements; ///< of the reference
  double own_vertices, own_hexahedra, own_elements, gridlets, full, empty;
};
constexpr DualFigures zellmann_duals[] = {
    {"TAC Molecular Cloud", na, na, na, na, 83.6, na, na, na, na, na, 0.072},
    {"LANL Impact", 283, 4.2, 6.8, 278, 289, 20.5, 5.8, 16.8, 671, 399, 22.1},
    {"NASA Landing Gear", 262, 2.4, 4.4, 259, 266, 11.3, 2.3, 9.1, 512, 366, 0.0901},
    {"NASA Exajet", 656, 2.5, 4.1, 652, 659, 12.6, 3.5, 10.1, 1370, 931, 13.7}};

/// Tables 2 to 4, in the same order. Table 2: gigabytes (of 2^30, as the counts of table 1 say).
/// Table 3: gigabytes: data, peak, total. Table 4: frames a second.
struct AmrFigures {
  double cubes, gridlets, rate;
  double reference[3], quick_clusters[3], compressed[3], exabrick[3], ours[3];
  double fps[5]; ///< reference, Quick Clusters, compressed, ExaBrick, theirs
};
constexpr AmrFigures zellmann_figures[] = {{3.46,
                                            0.432,
                                            8.2,
                                            {3.71, 17.7, 6.83},
                                            {2.65, 6.40, 5.17},
                                            {3.14, 4.62, 4.62},
                                            {0.34, 1.70, 1.60},
                                            {0.68, 2.36, 2.16},
                                            {10.3, 2.29, 4.63, 22.7, 18.7}},
                                           {12.0,
                                            1.59,
                                            7.5,
                                            {12.8, oom, oom},
                                            {9.15, 24.6, 14.4},
                                            {10.9, 15.6, 13.0},
                                            {2.93, 12.1, 5.89},
                                            {2.39, 5.15, 4.24},
                                            {oom, 0.60, 3.04, 6.09, 3.86}},
                                           {11.4,
                                            1.38,
                                            8.3,
                                            {11.9, oom, oom},
                                            {8.49, 22.7, 16.3},
                                            {10.1, 15.4, 15.4},
                                            {1.03, 5.64, 5.59},
                                            {1.85, 7.20, 6.72},
                                            {oom, 0.52, 0.66, 3.26, 1.48}},
                                           {28.9,
                                            3.56,
                                            8.1,
                                            {30.5, oom, oom},
                                            {oom, oom, oom},
                                            {25.6, 36.8, 33.8},
                                            {5.92, 21.0, 12.6},
                                            {5.09, 11.0, 10.5},
                                            {oom, oom, 1.58, 3.67, 2.09}}};

} // namespace insitu::bench::paper
