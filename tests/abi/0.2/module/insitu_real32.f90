!> The calls of insitu_mesh that take real32 arrays.
module insitu_real32
  use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  use insitu_arrays, only: array_of, nothing
  use insitu_c, only: c_array, c_block, insitu_block_rectilinear, insitu_cell, insitu_ok, &
      insitu_vertex, wp_type => insitu_float32
  use insitu_core, only: below => mesh_core
  implicit none
  private

  integer, parameter :: wp = real32

  type, extends(below), public :: mesh_of_reals
  contains
    procedure, private :: points_interleaved_r32 => points_interleaved
    procedure, private :: points_1_r32 => points_1
    procedure, private :: points_2_r32 => points_2
    procedure, private :: curvilinear_interleaved_r32 => curvilinear_interleaved
    procedure, private :: curvilinear_3_r32 => curvilinear_3
    procedure, private :: rectilinear_r32 => rectilinear
    procedure, private :: flat_points_r32 => flat_points_1
    procedure, private :: flat_curvilinear_r32 => flat_curvilinear
    procedure, private :: flat_rectilinear_r32 => flat_rectilinear
    procedure, private :: vertex_1_r32 => vertex_1
    procedure, private :: vertex_2_r32 => vertex_2
    procedure, private :: vertex_3_r32 => vertex_3
    procedure, private :: vertex_4_r32 => vertex_4
    procedure, private :: vertex_uvw_1_r32 => vertex_uvw_1
    procedure, private :: vertex_uvw_2_r32 => vertex_uvw_2
    procedure, private :: vertex_uvw_3_r32 => vertex_uvw_3
    procedure, private :: cell_1_r32 => cell_1
    procedure, private :: cell_2_r32 => cell_2
    procedure, private :: cell_3_r32 => cell_3
    procedure, private :: cell_4_r32 => cell_4
    procedure, private :: cell_uvw_1_r32 => cell_uvw_1
    procedure, private :: cell_uvw_2_r32 => cell_uvw_2
    procedure, private :: cell_uvw_3_r32 => cell_uvw_3
    procedure, private :: locate_interleaved_r32 => locate_interleaved
    procedure, private :: locate_1_r32 => locate_1
    procedure, private :: locate_interleaved_int32_r32 => locate_interleaved_int32
    procedure, private :: locate_1_int32_r32 => locate_1_int32
    procedure, private :: sample_interleaved_r32 => sample_interleaved
    procedure, private :: sample_interleaved_vector_r32 => sample_interleaved_vector
    procedure, private :: sample_1_r32 => sample_1
    procedure, private :: sample_1_vector_r32 => sample_1_vector
    procedure, private :: nearest_interleaved_r32 => nearest_interleaved
    procedure, private :: nearest_1_r32 => nearest_1
    generic :: points => points_interleaved_r32, points_1_r32, points_2_r32
    generic :: curvilinear_block => curvilinear_interleaved_r32, curvilinear_3_r32
    generic :: rectilinear_block => rectilinear_r32
    generic :: flat_points => flat_points_r32
    generic :: flat_curvilinear_block => flat_curvilinear_r32
    generic :: flat_rectilinear_block => flat_rectilinear_r32
    generic :: vertex_field => vertex_1_r32, vertex_2_r32, vertex_3_r32, vertex_4_r32, &
        vertex_uvw_1_r32, vertex_uvw_2_r32, vertex_uvw_3_r32
    generic :: cell_field => cell_1_r32, cell_2_r32, cell_3_r32, cell_4_r32, cell_uvw_1_r32, &
        cell_uvw_2_r32, cell_uvw_3_r32
    generic :: locate => locate_interleaved_r32, locate_1_r32, locate_interleaved_int32_r32, &
        locate_1_int32_r32
    generic :: sample => sample_interleaved_r32, sample_interleaved_vector_r32, sample_1_r32, &
        sample_1_vector_r32
    generic :: nearest_vertices => nearest_interleaved_r32, nearest_1_r32
  end type mesh_of_reals

contains

  include 'insitu_reals.inc'
  include 'insitu_queries.inc'

end module insitu_real32
