!> The calls of insitu_mesh that take int64 arrays.
module insitu_int64
  use, intrinsic :: iso_c_binding, only: c_int, c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64, int8
  use insitu_arrays, only: array_of, nothing, view_of_bytes
  use insitu_c, only: c_array, c_cells, c_faces, c_leaves, insitu_cell, insitu_faces_cells, &
      insitu_faces_owners, insitu_hexahedron, insitu_layout_mixed, &
      insitu_layout_padded, insitu_layout_uniform, insitu_pixel, insitu_pyramid, insitu_quad, &
      insitu_tetrahedron, insitu_triangle, &
      insitu_vertex, insitu_voxel, insitu_wedge, ip_type => insitu_int64
  use insitu_int32, only: below => mesh_of_integers
  implicit none
  private

  integer, parameter :: ip = int64

  type, extends(below), public :: mesh_of_integers
  contains
    procedure, private :: tetrahedra_i64 => tetrahedra
    procedure, private :: pyramids_i64 => pyramids
    procedure, private :: wedges_i64 => wedges
    procedure, private :: hexahedra_i64 => hexahedra
    procedure, private :: voxels_i64 => voxels
    procedure, private :: triangles_i64 => triangles
    procedure, private :: pixels_i64 => pixels
    procedure, private :: quads_i64 => quads
    procedure, private :: padded_flat_i64 => padded_flat
    procedure, private :: padded_i64 => padded
    procedure, private :: mixed_i64 => mixed
    procedure, private :: faces_i64 => faces
    procedure, private :: faces_of_cells_i64 => faces_of_cells
    procedure, private :: global_cells_i64 => global_cells
    procedure, private :: global_vertices_i64 => global_vertices
    procedure, private :: leaves_i64 => leaves
    procedure, private :: leaves_bytes_i64 => leaves_bytes
    generic :: tetrahedra => tetrahedra_i64
    generic :: pyramids => pyramids_i64
    generic :: wedges => wedges_i64
    generic :: hexahedra => hexahedra_i64
    generic :: voxels => voxels_i64
    generic :: triangles => triangles_i64
    generic :: pixels => pixels_i64
    generic :: quads => quads_i64
    generic :: flat_cells => padded_flat_i64
    generic :: cells => padded_i64, mixed_i64
    generic :: faces => faces_i64
    generic :: faces_of_cells => faces_of_cells_i64
    generic :: global_cells => global_cells_i64
    generic :: global_vertices => global_vertices_i64
    generic :: leaves => leaves_i64, leaves_bytes_i64
  end type mesh_of_integers

contains

  include 'insitu_integers.inc'

end module insitu_int64
