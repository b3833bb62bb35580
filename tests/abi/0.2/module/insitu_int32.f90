!> The calls of insitu_mesh that take int32 arrays.
module insitu_int32
  use, intrinsic :: iso_c_binding, only: c_int, c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int32, int64, int8
  use insitu_arrays, only: array_of, nothing, view_of_bytes
  use insitu_c, only: c_array, c_cells, c_faces, c_leaves, insitu_cell, insitu_faces_cells, &
      insitu_faces_owners, insitu_hexahedron, insitu_layout_mixed, &
      insitu_layout_padded, insitu_layout_uniform, insitu_pixel, insitu_pyramid, insitu_quad, &
      insitu_tetrahedron, insitu_triangle, &
      insitu_vertex, insitu_voxel, insitu_wedge, ip_type => insitu_int32
  use insitu_real64, only: below => mesh_of_reals
  implicit none
  private

  integer, parameter :: ip = int32

  type, extends(below), public :: mesh_of_integers
  contains
    procedure, private :: tetrahedra_i32 => tetrahedra
    procedure, private :: pyramids_i32 => pyramids
    procedure, private :: wedges_i32 => wedges
    procedure, private :: hexahedra_i32 => hexahedra
    procedure, private :: voxels_i32 => voxels
    procedure, private :: triangles_i32 => triangles
    procedure, private :: pixels_i32 => pixels
    procedure, private :: quads_i32 => quads
    procedure, private :: padded_flat_i32 => padded_flat
    procedure, private :: padded_i32 => padded
    procedure, private :: mixed_i32 => mixed
    procedure, private :: faces_i32 => faces
    procedure, private :: faces_of_cells_i32 => faces_of_cells
    procedure, private :: global_cells_i32 => global_cells
    procedure, private :: global_vertices_i32 => global_vertices
    procedure, private :: leaves_i32 => leaves
    procedure, private :: leaves_bytes_i32 => leaves_bytes
    generic :: tetrahedra => tetrahedra_i32
    generic :: pyramids => pyramids_i32
    generic :: wedges => wedges_i32
    generic :: hexahedra => hexahedra_i32
    generic :: voxels => voxels_i32
    generic :: triangles => triangles_i32
    generic :: pixels => pixels_i32
    generic :: quads => quads_i32
    generic :: flat_cells => padded_flat_i32
    generic :: cells => padded_i32, mixed_i32
    generic :: faces => faces_i32
    generic :: faces_of_cells => faces_of_cells_i32
    generic :: global_cells => global_cells_i32
    generic :: global_vertices => global_vertices_i32
    generic :: leaves => leaves_i32, leaves_bytes_i32
  end type mesh_of_integers

contains

  include 'insitu_integers.inc'

end module insitu_int32
