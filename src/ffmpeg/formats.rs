//! The properties of ffmpeg's formats, by name.

use std::ffi::OsString;
use std::path::Path;

use super::command::{arguments, is_camera, is_url};

/// Formats that hold their own contents: all that ffmpeg 5.1 and 9 read from files (`ffmpeg -demuxers`), without
/// devices and without lists that name other files (hls, dash, concat, imf, sdp, vobsub ...). A file of such
/// a list must not open others unless its name says that it is a list.
const WHOLE_FILES: &str = "\
    3dostr,3g2,3gp,4xm,aa,aac,aax,ac3,ac4,ace,acm,act,adf,adp,ads,adx,aea,afc,\
    aiff,aix,alaw,alias_pix,alp,amr,amrnb,amrwb,anm,apac,apc,ape,apm,apng,aptx,\
    aptx_hd,apv,aqtitle,argo_asf,argo_brp,argo_cvg,asf,asf_o,ass,ast,au,av1,avi,avr,\
    avs,avs2,avs3,bethsoftvid,bfi,bfstm,bink,binka,bit,bitpacked,bmp_pipe,bmv,boa,bonk,\
    brender_pix,brstm,c93,caf,cavsvideo,cdg,cdxl,cine,codec2,codec2raw,cri_pipe,daud,\
    dcstr,dds_pipe,derf,dfa,dfpwm,dhav,dirac,dnxhd,dpx_pipe,dsf,dsicin,dss,dts,dtshd,\
    dv,dvbsub,dvbtxt,dxa,ea,ea_cdata,eac3,epaf,evc,exr_pipe,f32be,f32le,f64be,f64le,\
    film_cpk,filmstrip,fits,flac,flic,flv,frm,fsb,fwse,g722,g723_1,g726,g726le,g728,\
    g729,gdv,gem_pipe,genh,gif,gif_pipe,gsm,gxf,h261,h263,h264,hca,hcom,hdr_pipe,hevc,\
    hnm,hxvs,iamf,ico,idcin,idf,iff,ifv,ilbc,image2,image2pipe,ingenient,ipmovie,ipu,\
    ircam,iss,iv8,ivf,ivr,j2k_pipe,jacosub,jpeg_pipe,jpegls_pipe,jpegxl_anim,jpegxl_pipe,\
    jpegxs_pipe,jv,kux,kvag,laf,lc3,libgme,libopenmpt,live_flv,lmlm4,loas,lrc,luodat,\
    lvf,lxf,m4a,m4v,matroska,mca,mcc,mgsts,microdvd,mj2,mjpeg,mjpeg_2000,mlp,mlv,mm,\
    mmf,mods,moflex,mov,mp3,mp4,mpc,mpc8,mpeg,mpegts,mpegtsraw,mpegvideo,mpjpeg,mpl2,\
    mpsub,msf,msnwctcp,msp,mtaf,mtv,mulaw,musx,mv,mvi,mxf,mxg,nc,nistsphere,nsp,nsv,\
    nut,nuv,obu,ogg,oma,osq,paf,pam_pipe,pbm_pipe,pcx_pipe,pdv,pfm_pipe,pgm_pipe,\
    pgmyuv_pipe,pgx_pipe,phm_pipe,photocd_pipe,pictor_pipe,pjs,pmp,png_pipe,pp_bnk,\
    ppm_pipe,psd_pipe,psxstr,pva,pvf,qcp,qdraw_pipe,qoa,qoi_pipe,r3d,rcwt,realtext,\
    redspark,rka,rl2,rm,roq,rpl,rsd,rso,s16be,s16le,s24be,s24le,s32be,s32le,s337m,s8,\
    sami,sbc,sbg,scc,scd,sdns,sdr2,sds,sdx,ser,sga,sgi_pipe,shn,siff,simbiosis_imx,\
    sln,smjpeg,smk,smush,sol,sox,spdif,srt,stl,subviewer,subviewer1,sunrast_pipe,sup,\
    svag,svg_pipe,svs,swf,tak,tedcaptions,thp,tiertexseq,tiff_pipe,tmv,truehd,tta,txd,\
    ty,u16be,u16le,u24be,u24le,u32be,u32le,u8,usm,v210,v210x,vag,vbn_pipe,vc1,vc1test,\
    vidc,vividas,vivo,vmd,voc,vpk,vplayer,vqf,vvc,w64,wady,wav,wavarc,wc3movie,webm,\
    webp_anim,webp_pipe,webvtt,wsaud,wsd,wsvqa,wtv,wv,wve,xa,xbin,xbm_pipe,xmd,xmv,\
    xpm_pipe,xvag,xwd_pipe,xwma,yop,yuv4mpegpipe";

/// Extensions of lists that name other files.
const LISTS: [&str; 6] = ["m3u8", "m3u", "mpd", "ffconcat", "sdp", "idx"];

/// Formats with timestamps that may restart or jump: streams that are cut and joined anywhere. ffmpeg repairs them,
/// in all streams alike, unless `-copyts` keeps them.
const RESTARTING: [&str; 8] =
    ["mpegts", "mpegtsraw", "mpeg", "flv", "live_flv", "ogg", "hls", "applehttp"];

/// Options that state the format of the input `path`, and limit it.
pub(crate) fn input_format(path: &Path) -> Vec<OsString> {
    if is_camera(path) {
        return arguments([&"-f", &"v4l2"]);
    }
    let list = path.extension().and_then(|extension| extension.to_str());
    let list = list.is_some_and(|name| LISTS.iter().any(|list| name.eq_ignore_ascii_case(list)));
    if is_url(path) || list || path.starts_with("/dev") {
        return Vec::new();
    }
    arguments([&"-format_whitelist", &WHOLE_FILES])
}

/// Whether the timestamps of a `container`, by ffprobe's name, may restart.
pub(crate) fn restarts(container: &str) -> bool {
    container.split(',').any(|name| RESTARTING.contains(&name))
}

/// Options for an input in a `container` with timestamps that may restart: a demuxer that repairs them. The one for
/// FLV files does not, the one for live FLV does.
pub(crate) fn mending(container: &str) -> Vec<OsString> {
    if container == "flv" { arguments([&"-f", &"live_flv"]) } else { Vec::new() }
}

/// Whether a `container` lists parts that may grow for ever, so that its own size says nothing.
pub(crate) fn is_list(container: &str) -> bool {
    container.split(',').any(|name| ["hls", "applehttp", "dash", "sdp", "rtsp"].contains(&name))
}

/// Whether a `container` holds one still picture.
pub(crate) fn is_still(container: &str) -> bool {
    container.ends_with("_pipe") || ["image2", "ico"].contains(&container)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_told_by_their_names() {
        assert_eq!(input_format(Path::new("in.mp4")).len(), 2);
        assert!(input_format(Path::new("in.M3U8")).is_empty());
        assert!(input_format(Path::new("http://host/in.mp4")).is_empty());
        let allowed = |name: &str| WHOLE_FILES.split(',').any(|allowed| allowed == name);
        assert!(["mp4", "matroska", "mpegts", "svg_pipe", "nut"].iter().all(|name| allowed(name)));
        assert!(
            ["hls", "dash", "concat", "lavfi", "v4l2", "sdp"].iter().all(|name| !allowed(name))
        );
        assert!(!WHOLE_FILES.contains(' '));
    }

    #[test]
    fn stills_and_restarting_clocks_are_known() {
        assert!(is_still("jpegxl_pipe") && is_still("image2") && !is_still("jpegxl_anim"));
        assert!(restarts("mpegts") && !restarts("mov,mp4,m4a,3gp,3g2,mj2"));
    }
}
