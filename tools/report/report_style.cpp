#include <fmt/format.h>

#include "tools/report/report_sections.h"
#include "tools/report/text/html_text.h"

namespace parloc::tools {

// Colours: Okabe and Ito's set for colour-blind readers. Lines differ in width and dashes too.
const char* report_style() {
  return R"css(
:root{color-scheme:light dark;--page:#fff;--text:#1b1f24;--soft:#5b6570;--rule:#d8dde3;--panel:#f5f7f9;
--c1:#0072b2;--c2:#e69f00;--c3:#b5508c;--c4:#009e73;--c5:#d55e00;--c6:#5b6570}
@media(prefers-color-scheme:dark){:root{--page:#14171b;--text:#e6e9ec;--soft:#9aa5b1;--rule:#333b44;--panel:#1d2228;
--c1:#56b4e9;--c2:#f0b429;--c3:#e58ac0;--c4:#2fcf9f;--c5:#ff7a33;--c6:#9aa5b1}.cells{filter:url(#invert)}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:70rem;padding:1rem;background:var(--page);color:var(--text);
font:16px/1.45 system-ui,sans-serif}
h1{font-size:1.5rem;margin:.2rem 0;overflow-wrap:anywhere}
h2{font-size:1.15rem;margin:2rem 0 .6rem}
p{margin:.4rem 0}
code{display:block;padding:.5rem .7rem;background:var(--panel);border-radius:.4rem;font-size:.85rem;
overflow-wrap:anywhere;white-space:pre-wrap}
.note{color:var(--soft);font-size:.9rem}
.warning{border-left:.3rem solid var(--c5);padding:.4rem .7rem;background:var(--panel);overflow-wrap:anywhere}
.warning ul{margin:.2rem 0;padding-left:1.2rem}
table{border-collapse:collapse;width:100%}
th,td{text-align:left;vertical-align:top;padding:.28rem .5rem .28rem 0;border-bottom:1px solid var(--rule);
font-weight:400;overflow-wrap:anywhere}
th{color:var(--soft);width:38%}
td{font-variant-numeric:tabular-nums}
.summary td{font-weight:600}
.tables{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,22rem),1fr));gap:0 2rem;align-items:start}
figure{margin:0}
figcaption{font-size:.9rem;margin-bottom:.3rem}
svg{display:block;width:100%}
.key{display:inline-block;margin-left:1rem;color:var(--soft);white-space:nowrap}
.key i{display:inline-block;width:1.3rem;height:.75em;margin-right:.35rem;vertical-align:-.05em}
.key svg{display:inline-block;width:2rem;height:.875rem;margin-right:.35rem;vertical-align:-.1em}
.key i.line{height:0;border-top:.2rem solid;vertical-align:.25em}
.key .wide{height:0;border-top:.38rem solid;vertical-align:.2em}
.key .dash{height:0;border-top:.15rem dashed;vertical-align:.25em}
.key .area{background:currentColor;opacity:.25}
.key .tick{width:0;height:.8em;border-left:.15rem solid}
.key .dot{width:.55rem;height:.55rem;border-radius:50%;background:currentColor;vertical-align:0}
.key .ring{width:.75rem;height:.75rem;border-radius:50%;border:.15rem solid;vertical-align:-.1em}
.key .box{width:.65rem;height:.65rem;background:currentColor;vertical-align:-.02em}
i.c1{color:var(--c1)}i.c2{color:var(--c2)}i.c3{color:var(--c3)}i.c4{color:var(--c4)}i.c5{color:var(--c5)}
i.c6{color:var(--c6)}
path{fill:none;vector-effect:non-scaling-stroke;stroke-linejoin:round;stroke-linecap:round}
.c1{stroke:var(--c1)}.c2{stroke:var(--c2)}.c3{stroke:var(--c3)}.c4{stroke:var(--c4)}.c5{stroke:var(--c5)}
.c6{stroke:var(--c6)}
.map{position:relative;margin:0 auto;background:var(--page);border:1px solid var(--rule)}
.map,.closeups{image-rendering:pixelated}
.truth{stroke-width:5.5px}
.estimate{stroke-width:1.8px}
.odometry{stroke-width:1.6px;stroke-dasharray:6 4}
.faint{opacity:.25}.half{opacity:.55}
.snap,.trail,.closeups use{stroke-width:2.6px}
.trail{opacity:.35}
.closeups use.dots{stroke-width:1.7px}
.arrow{stroke:var(--text);stroke-width:2.4px}
.spot{stroke-width:13px}
.hole{stroke:var(--page);stroke-width:7px}
.end{stroke-linecap:square;stroke-width:10px}
.scale{position:absolute;left:.7rem;bottom:.5rem;border-bottom:.2rem solid var(--text);color:var(--text);
font-size:.8rem;line-height:1.4;text-align:center;white-space:nowrap;background:var(--page);box-shadow:0 0 0 .3rem var(--page)}
.moment{display:flex;gap:.8rem;align-items:center;margin:.6rem 0}
.moment input{flex:1;min-width:0;accent-color:var(--c4)}
output{white-space:nowrap;font-variant-numeric:tabular-nums}
.closeups{display:grid;grid-template-columns:repeat(auto-fill,minmax(9.5rem,1fr));gap:.7rem}
.closeups figure{cursor:pointer}
.closeups figcaption{font-size:.8rem;margin:.15rem 0 0;color:var(--soft)}
.closeups svg{border:1px solid var(--rule);background:var(--page)}
.closeups .chosen svg{outline:2px solid var(--c4)}
.grown{stroke-width:1.8px}
.grown .cloud{stroke-width:3.5px}
.robot{stroke-width:9px}
.frames{display:grid;grid-template-columns:repeat(auto-fill,minmax(7.5rem,1fr));gap:.7rem;margin-top:.8rem}
.frames figure{cursor:pointer}
.frames figcaption{font-size:.8rem;margin:.15rem 0 0;color:var(--soft)}
.frames svg{border:1px solid var(--rule);background:var(--page)}
.frames use{stroke-width:1px}
.frames .chosen svg{outline:2px solid var(--c4)}
.told{display:grid;grid-template-columns:repeat(auto-fit,minmax(8.5rem,1fr));gap:.5rem 1.2rem;margin:.6rem 0 0}
.told dt{color:var(--soft);font-size:.8rem}
.told dd{margin:0;white-space:nowrap;font-weight:600;font-variant-numeric:tabular-nums}
button{font:inherit;min-width:4.6rem;padding:.15rem .7rem;border:1px solid var(--rule);border-radius:.4rem;
background:var(--panel);color:var(--text);cursor:pointer}
[hidden]{display:none!important}
.plots,.sizes{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,26rem),1fr));gap:1.3rem 1.6rem}
.sizes{grid-template-columns:repeat(auto-fit,minmax(min(100%,20rem),1fr))}
.axes{display:grid;grid-template-columns:3.4rem 1fr;grid-template-rows:9.5rem 1.5rem}
.sizes .axes{grid-template-rows:15rem 2.6rem;margin-right:.7rem}
.axes .y,.axes .x,.axes .area{position:relative;font-size:.75rem;color:var(--soft)}
.axes .y span{position:absolute;right:.4rem;transform:translateY(-50%);white-space:nowrap}
.axes .x{grid-column:2}
.axes .x span{position:absolute;top:.2rem;transform:translateX(-50%);white-space:nowrap}
.plots .x span:first-child{transform:none}
.axes .x em{position:absolute;right:0;top:.2rem;background:var(--page);padding-left:.4rem}
.sizes .x em{left:0;top:1.35rem;text-align:center;font-style:normal}
.area>svg{height:100%;background:var(--panel)}
.area>.points{position:absolute;inset:0;background:none}
.points,.points svg{overflow:visible}
.area>span{position:absolute;left:.4rem}
.grid{stroke:var(--rule);stroke-width:1px}
.line,.key .line{stroke-width:1.5px}
.sizes path.line{stroke-width:2px}
.axes .pale{opacity:.45}
path.dashes{stroke-width:1.5px;stroke-dasharray:5 4}
.axes path.dash{stroke-width:1.6px;stroke-dasharray:6 4}
.axes path.tick{stroke-width:1.2px;stroke-linecap:butt}
path.band{stroke:none;opacity:.2}path.full{opacity:.6}
path.hollow{fill:var(--page);stroke-width:1.4px}
path.solid{stroke-width:1px}
.band.c1,.solid.c1{fill:var(--c1)}.band.c2,.solid.c2{fill:var(--c2)}.band.c3,.solid.c3{fill:var(--c3)}
.band.c4,.solid.c4{fill:var(--c4)}.band.c5,.solid.c5{fill:var(--c5)}.band.c6,.solid.c6{fill:var(--c6)}
.legend{display:flex;flex-wrap:wrap;gap:.2rem 1.3rem;font-size:.9rem;margin:.6rem 0}
.legend .key{margin:0;color:var(--text)}
.wide{overflow-x:auto}
table.numbers{width:auto;margin:.6rem 0 1.2rem}
.numbers caption{text-align:left;font-weight:600;padding:.3rem 0}
.numbers th,.numbers td{width:auto;text-align:right;padding:.15rem 0 .15rem 1.1rem;white-space:nowrap;font-size:.88rem}
.numbers .left{text-align:left}
.numbers tr>*:first-child{padding-left:0}
.numbers .group{text-align:center}
.numbers .within{font-weight:600}
summary{cursor:pointer;color:var(--soft);margin:.4rem 0}
.now{position:absolute;top:0;bottom:0;width:0;border-left:1px solid var(--c4);display:none}
@media print{.moment{display:none}}
)css";
}

const char* report_script() {
  return R"js(
const all=q=>[...document.querySelectorAll(q)];
function through(id,out,layers,texts,pictures){const slider=document.getElementById(id);if(!slider)return;
const show=()=>{const k=+slider.value,m=layers[k];
layers.forEach((e,i)=>{e.style.display=i===k?'inline':'none'});
texts.forEach((e,i)=>{e.style.display=i===k?'':'none'});
pictures.forEach((e,i)=>e.classList.toggle('chosen',i===k));
document.getElementById(out).textContent=m.dataset.time;
all('.now').forEach(e=>{e.style.display='block';e.style.left=m.dataset.at+'%'})};
slider.addEventListener('input',show);
pictures.forEach((e,i)=>e.addEventListener('click',()=>{slider.value=i;show()}));
all('.scripted').forEach(e=>{e.hidden=false});show();return k=>{slider.value=k;show()}}
through('moment','when',all('.snap'),[],all('.closeups figure'));
const grow=through('grow','grow-at',all('.grown'),all('.told'),all('.frames figure'));
if(grow){const slider=document.getElementById('grow'),button=document.getElementById('play');let timer=0;
const stop=()=>{clearInterval(timer);timer=0;button.textContent='Play'};
const next=()=>{if(+slider.value>=+slider.max)stop();else grow(+slider.value+1)};
button.addEventListener('click',()=>{if(timer)return stop();
if(+slider.value>=+slider.max)grow(0);button.textContent='Pause';timer=setInterval(next,400)});
slider.addEventListener('input',stop);all('.frames figure').forEach(e=>e.addEventListener('click',stop))}
)js";
}

std::string page_head(const std::string& title, const std::string& date, const std::string& command,
                      const char* style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>{}</title><style>{}{}</style></head><body>\n"
      "<h1>{}</h1>\n<p class=\"note\">{}</p><code>{}</code>\n",
      escape_html(title), report_style(), style, escape_html(title), escape_html(date), escape_html(command));
}

}  // namespace parloc::tools
